#include "lab/loadgen/load_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

namespace isthmus::loadgen {
namespace {

using testing::HasSubstr;

TEST(LoadReport, PercentilesAreOfTheNearestRank) {
  std::vector<double> values(200);
  std::iota(values.rbegin(), values.rend(), 1.0);  // 200 ... 1: order does not matter.
  const Spread spread = SpreadOf(values);
  EXPECT_EQ(spread.p50, 100);
  EXPECT_EQ(spread.p90, 180);
  EXPECT_EQ(spread.p99, 198);
  EXPECT_EQ(spread.max, 200);
  EXPECT_EQ(SpreadOf({7}).p99, 7);
  EXPECT_EQ(SpreadOf({}).max, 0);
}

LoadResult TwoRobots() {
  LoadResult result;
  result.seconds = 10;
  result.robots.resize(2);
  for (RobotResult& robot : result.robots) {
    robot.pushed = robot.processed = 100;
    robot.cloud_bytes = 5'000'000;
    robot.ack_ms.assign(100, 5);
  }
  result.server = {{0, {1, 100, 10, 20}}, {4, {2, 130, 12, 20}}, {10, {3, 150, 12, 20}}};
  return result;
}

TEST(LoadReport, SharesTheServersTimeAmongScans) {
  const cli::Json json = ToJson(TwoRobots());
  EXPECT_EQ(json["processed"], 200);
  EXPECT_DOUBLE_EQ(json["server"]["cpu_per_scan_ms"], 10);
  EXPECT_DOUBLE_EQ(json["server"]["cores"], 0.2);
  EXPECT_DOUBLE_EQ(json["wire_kb_s"], 500);
  EXPECT_THAT(ToText(TwoRobots()), HasSubstr("150 MB"));
}

TEST(LoadReport, AScanWithoutAnAnswerIsAFailure) {
  LoadResult result = TwoRobots();
  EXPECT_TRUE(AllAnswered(result));
  result.robots[1].unanswered = 1;
  EXPECT_FALSE(AllAnswered(result));
  EXPECT_THAT(ToText(result), HasSubstr("1 without an answer"));
  result = TwoRobots();
  result.robots[0].status = absl::UnavailableError("gone");
  EXPECT_FALSE(AllAnswered(result));
  EXPECT_THAT(ToText(result), HasSubstr("gone"));
}

}  // namespace
}  // namespace isthmus::loadgen
