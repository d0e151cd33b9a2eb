#include "client/library/spool/memory_spool.h"

#include <gtest/gtest.h>

#include <string>

namespace isthmus::client {
namespace {

constexpr uint64_t kBytes = 10;  // Bytes of every scan.

std::string LettersOf(uint64_t k) { return std::string(kBytes, static_cast<char>('a' + k)); }

// Scans 1, 2, ..., that end at 100, 200, ...
void AppendTo(MemorySpool& spool, uint64_t count) {
  for (uint64_t k = 1; k <= count; ++k) {
    ASSERT_TRUE(spool.Append(static_cast<int64_t>(100 * k), LettersOf(k), 1.0).ok());
  }
}

TEST(MemorySpool, KeepsScansUntilTheyAreDurable) {
  MemorySpool spool({}, 0, 1000);
  AppendTo(spool, 4);
  EXPECT_EQ(spool.safe(), 4u);
  EXPECT_EQ(spool.bytes(), 4 * kBytes);
  spool.Release(2, 4);
  EXPECT_EQ(spool.first(), 3u);
  EXPECT_EQ(spool.bytes(), 2 * kBytes);
  EXPECT_TRUE(absl::IsNotFound(spool.Read(2).status()));
  EXPECT_FALSE(spool.Find(2).has_value());
  EXPECT_EQ(*spool.Read(3), LettersOf(3));
  EXPECT_EQ(spool.Find(4)->bytes, kBytes);
  EXPECT_FALSE(spool.Find(5).has_value());
  spool.Release(4, 4);
  EXPECT_EQ(spool.written(), 4u);
  EXPECT_EQ(spool.StampBefore(5), 400) << "though it is not kept";
}

TEST(MemorySpool, GivesUpTheOldestAcknowledgedOnly) {
  MemorySpool spool({}, 0, 2 * kBytes);
  AppendTo(spool, 8);
  spool.Release(0, 5);
  EXPECT_EQ(spool.first(), 6u) << "three more than may be are without acknowledgement";
  spool.Release(7, 5);
  EXPECT_EQ(spool.first(), 6u) << "its outcome is still to be told";
  spool.Release(0, 8);
  EXPECT_EQ(spool.first(), 7u);
}

TEST(MemorySpool, NumbersFollowTheServer) {
  MemorySpool spool({}, 40, 1000);
  EXPECT_EQ(spool.written(), 40u);
  AppendTo(spool, 2);
  EXPECT_EQ(*spool.Read(41), LettersOf(1));
  for (const uint64_t last : {45u, 7u}) {
    ASSERT_TRUE(spool.Skip(spool.first() - 1, last).ok());
    EXPECT_EQ(spool.written(), last + 2);
    EXPECT_EQ(*spool.Read(last + 1), LettersOf(1));
    EXPECT_EQ(spool.StampBefore(last + 1), 0);
    EXPECT_EQ(spool.StampBefore(last + 2), 100);
    EXPECT_EQ(spool.StampBefore(last + 9), 200);
  }
  EXPECT_TRUE(absl::IsAborted(spool.Skip(8, 20))) << "scan 8 keeps its number";
}

}  // namespace
}  // namespace isthmus::client
