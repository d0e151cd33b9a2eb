#include "server/ingest/scan_times.h"

#include <gtest/gtest.h>

#include "server/ingest/limits.h"

namespace isthmus::ingest {
namespace {

TEST(ScanTimes, KnowsWhenEachScanCame) {
  ScanTimes times;
  EXPECT_EQ(times.Of(1), 0);
  for (int i = 5; i < 9; ++i) times.Note(i, 100 * i);
  EXPECT_EQ(times.Of(4), 0);  // Before the first.
  for (int i = 5; i < 9; ++i) EXPECT_EQ(times.Of(i), 100 * i);
  times.ForgetUpTo(6);
  EXPECT_EQ(times.size(), 2u);
  EXPECT_EQ(times.Of(7), 700);
  times.ForgetUpTo(8);
  EXPECT_EQ(times.size(), 0u);
  times.Note(9, 900);
  EXPECT_EQ(times.Of(9), 900);
}

TEST(ScanTimes, IsBoundedAndErrsByLittle) {
  ScanTimes times;
  const uint64_t last = 3 * kMaxScanTimes;
  for (uint64_t i = 1; i <= last; ++i) times.Note(i, static_cast<int64_t>(i));
  EXPECT_LE(times.size(), kMaxScanTimes);
  EXPECT_EQ(times.Of(last), static_cast<int64_t>(last));
  EXPECT_EQ(times.Of(1), 1);  // The oldest counts most.
  for (uint64_t i = 1; i <= last; ++i) {
    EXPECT_LE(times.Of(i), static_cast<int64_t>(i));
    EXPECT_GT(times.Of(i), static_cast<int64_t>(i) - 16);
  }
  times.ForgetUpTo(last - 1);
  EXPECT_EQ(times.size(), 1u);
}

}  // namespace
}  // namespace isthmus::ingest
