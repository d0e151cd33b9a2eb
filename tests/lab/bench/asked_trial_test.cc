#include "lab/bench/merging/asked_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lab/bench/merging/asked_table.h"

namespace isthmus::bench {
namespace {

using ::testing::HasSubstr;

// Robots that both stroll through one flat, too short for their maps to be joined.
WildPair Pair() {
  WildPair pair;
  pair.kind = "flat";
  pair.seed = 30;
  pair.a = {.world = "wild-flat", .seed = 30, .seconds = 6, .robots = 2, .first_day = true};
  pair.b = pair.a;
  pair.b.robot = 1;
  return pair;
}

// Back to where the robot's drive began, as if that told something.
std::vector<AskedDrive> BackAgain(const DrivenRobot& robot, bool by_b) {
  AskedDrive drive;
  drive.by_b = by_b;
  drive.length_m = 5;
  drive.confidence = 0.9;
  for (size_t i = robot.submaps.size(); i-- > 0;) {
    const Submap& submap = *robot.submaps[i];
    for (size_t k = submap.keyframes.size(); k-- > 0;) {
      drive.way.push_back(
          {static_cast<uint32_t>(i), submap.keyframes[k].T_submap_sensor.translation()});
    }
  }
  return {drive};
}

TEST(RunAskedTrial, DrivesAsAskedAndByItself) {
  DriveCache cache("", {});
  server::PipelineOptions options;
  size_t asked = 0;  // Robot a, then b, then nobody.
  const auto trial = RunAskedTrial(
      Pair(), 1, options, cache, [&](const Match&, const std::vector<DrivenRobot>& robots) {
        const size_t by = asked++;
        return by < 2 ? BackAgain(robots[by], by == 1) : std::vector<AskedDrive>();
      });
  ASSERT_TRUE(trial.ok()) << trial.status();
  ASSERT_TRUE(trial->Waits()) << AskedLines(*trial);
  ASSERT_EQ(trial->steps.size(), 2u);
  EXPECT_EQ(trial->steps[0].robot, 0);
  EXPECT_EQ(trial->steps[1].robot, 1);
  for (const AskedStep& step : trial->steps) {
    EXPECT_GT(step.metres, 0.5);
    EXPECT_FALSE(step.blocked);
    EXPECT_EQ(step.predicted, 0.9);
    EXPECT_NE(step.asked.outcome, AskedOutcome::kLost);
    EXPECT_NE(step.wandering.outcome, AskedOutcome::kLost);
  }
  EXPECT_THAT(AskedTables({*trial}), HasSubstr("| asked, 1 |"));
  EXPECT_EQ(ToJson(*trial)["drives"].size(), trial->steps.size());
}

TEST(RunAskedTrial, DrivesNowhereWhereNothingIsAsked) {
  DriveCache cache("", {});
  const auto trial =
      RunAskedTrial(Pair(), 1, {}, cache, [](const auto&...) { return std::vector<AskedDrive>(); });
  ASSERT_TRUE(trial.ok()) << trial.status();
  EXPECT_TRUE(trial->steps.empty());
  EXPECT_THAT(AskedLines(*trial), HasSubstr("nothing to ask"));
}

}  // namespace
}  // namespace isthmus::bench
