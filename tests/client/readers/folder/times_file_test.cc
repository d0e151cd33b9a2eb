#include "client/readers/folder/times_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::readers {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(TimesFile, KeepsEveryNanosecondOfUnixTime) {
  const auto stamps = ParseTimes("1600000000.123456789\n1600000000.123456790\r\n");
  ASSERT_TRUE(stamps.ok()) << stamps.status();
  EXPECT_THAT(*stamps, ElementsAre(1600000000123456789, 1600000000123456790));
}

TEST(TimesFile, ReadsKittisScientificNotationAndWholeSeconds) {
  const auto stamps = ParseTimes("0.000000e+00\n1.036224e-01\n\n2\n3.5\n");
  ASSERT_TRUE(stamps.ok()) << stamps.status();
  EXPECT_THAT(*stamps, ElementsAre(0, 103622400, 2000000000, 3500000000));
}

TEST(TimesFile, TakesTimesOfAClockThatWasSet) {
  const auto stamps = ParseTimes("1\n2\n2\n0.5\n");
  ASSERT_TRUE(stamps.ok()) << stamps.status();
  EXPECT_THAT(*stamps, ElementsAre(1000000000, 2000000000, 2000000000, 500000000));
}

TEST(TimesFile, NamesTheLineThatIsWrong) {
  EXPECT_THAT(std::string(ParseTimes("1\nnoon\n").status().message()), HasSubstr("line 2"));
  EXPECT_THAT(std::string(ParseTimes("inf\n").status().message()), HasSubstr("line 1"));
  EXPECT_FALSE(ParseTimes("1.-5\n").ok());
  // The nanoseconds between two of these are no int64.
  EXPECT_FALSE(ParseTimes("-9e9\n").ok());
  EXPECT_FALSE(ParseTimes("8999999999.5\n").ok());
  EXPECT_FALSE(ParseTimes("2201-01-01 00:00:00\n").ok());
}

}  // namespace
}  // namespace isthmus::readers
