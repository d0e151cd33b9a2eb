#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/console/console.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ProgressLine, SaysHowFastAndHowLongStill) {
  const std::string line = ProgressLine("scans", 40, 160, 10, 80);
  EXPECT_THAT(line, HasSubstr("40/160  4/s  0:30 left"));
  EXPECT_THAT(line, HasSubstr("[====="));
  EXPECT_LT(line.size(), 80u);
}

TEST(ProgressLine, FitsTheTerminal) {
  for (const size_t columns : {10u, 25u, 40u, 79u, 300u}) {
    EXPECT_LT(ProgressLine("scans", 40, 160, 10, columns).size(), columns);
  }
  EXPECT_THAT(ProgressLine("scans", 40, 160, 10, 30), Not(HasSubstr("[")));
}

TEST(ProgressLine, WithoutATotalThereIsNoTimeLeft) {
  EXPECT_EQ(ProgressLine("scans", 40, 0, 10, 80), "scans 40  4/s");
  EXPECT_THAT(ProgressLine("scans", 160, 160, 10, 80), Not(HasSubstr("left")));
  EXPECT_THAT(ProgressLine("scans", 0, 160, 0, 80), HasSubstr("0/160"));
}

}  // namespace
}  // namespace isthmus::cli
