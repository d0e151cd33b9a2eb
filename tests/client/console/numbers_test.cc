#include "client/console/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace isthmus::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(Numbers, AreTakenOrRefusedInAFewWords) {
  for (const std::string good : {"1", "0.5", "1e-300", "9223372036854775807", "+3"}) {
    EXPECT_EQ(Positive()(good), "");
    EXPECT_EQ(NotNegative()(good), "");
  }
  EXPECT_EQ(NotNegative()("0"), "");
  EXPECT_THAT(Positive()("0"), HasSubstr("above 0"));
  EXPECT_THAT(NotNegative()("-3"), HasSubstr("from 0 on"));
  // CLI11 would take the nearest that fits.
  EXPECT_THAT(Positive()("99999999999999999999"), HasSubstr("too large"));
  for (const std::string bad : {"", "x", "nan", "inf", "1e999", "-1"}) {
    EXPECT_THAT(Positive()(bad), testing::AllOf(testing::Not(""), SizeIs(testing::Lt(60)))) << bad;
  }
}

TEST(Numbers, BetweenTwoAreTakenOnly) {
  for (const std::string good : {"0", "0.1", "1e-2"}) EXPECT_EQ(Between(0, 0.1)(good), "");
  EXPECT_THAT(Between(0, 0.1)("0.2"), HasSubstr("from 0 to 0.1, not 0.2"));
  for (const std::string bad : {"nan", "-0.1", "inf", "x"}) EXPECT_NE(Between(0, 0.1)(bad), "");
}

}  // namespace
}  // namespace isthmus::cli
