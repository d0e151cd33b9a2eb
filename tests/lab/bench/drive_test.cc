#include "lab/bench/drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lab/bench/scenarios.h"

namespace isthmus::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<int> Turns(const Shots& shots) {
  std::vector<int> turns;
  for (const Shot& shot : shots) turns.push_back(shot.turn);
  return turns;
}

// Seconds from each shot to the next.
std::vector<double> Steps(const Shots& shots) {
  std::vector<double> steps;
  for (size_t i = 1; i < shots.size(); ++i) {
    steps.push_back(1e-9 * static_cast<double>(shots[i].end_stamp_ns - shots[i - 1].end_stamp_ns));
  }
  return steps;
}

TEST(Shots, InOrderAreOneTurnApart) {
  const Shots shots = InOrder(4, 0.1);
  EXPECT_THAT(Turns(shots), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(Steps(shots), ElementsAre(0.1, 0.1, 0.1));
}

TEST(Shots, DropLeavesAGapInTime) {
  Shots shots = InOrder(5, 0.1);
  Drop(&shots, 1, 2);
  EXPECT_THAT(Turns(shots), ElementsAre(0, 3, 4));
  EXPECT_THAT(Steps(shots), ElementsAre(testing::DoubleNear(0.3, 1e-9), 0.1));
}

TEST(Shots, DuplicateAndSwapKeepTheStamps) {
  Shots shots = InOrder(4, 0.1);
  Swap(&shots, 2);
  Duplicate(&shots, 0);
  EXPECT_THAT(Turns(shots), ElementsAre(0, 0, 1, 3, 2));
  EXPECT_EQ(shots[0].end_stamp_ns, shots[1].end_stamp_ns);
  EXPECT_GT(shots[3].end_stamp_ns, shots[4].end_stamp_ns);
}

TEST(Shots, ClockStepsAndCarriesLastToTheEnd) {
  Shots shots = InOrder(5, 0.1);
  StepClock(&shots, 2, -0.05);
  PutElsewhere(&shots, 3, -3);
  EXPECT_THAT(Turns(shots), ElementsAre(0, 1, 2, 0, 1));
  EXPECT_THAT(Steps(shots), ElementsAre(0.1, testing::DoubleNear(0.05, 1e-9), 0.1, 0.1));
}

TEST(MakeScan, ShowsAsMuchAsTheViewHas) {
  Drive drive;
  drive.scan_of = [](int turn) {
    Scan scan;
    scan.points = {{1, 0, 0}, {-1, static_cast<float>(turn), 0}};
    return scan;
  };
  Shot shot{3, 42};
  EXPECT_EQ(MakeScan(drive, shot, 7).points.size(), 2u);
  EXPECT_EQ(MakeScan(drive, shot, 7).sequence, 7u);
  EXPECT_EQ(MakeScan(drive, shot, 7).end_stamp_ns, 42);
  shot.view = View::kHalf;
  ASSERT_EQ(MakeScan(drive, shot, 7).points.size(), 1u);
  EXPECT_EQ(MakeScan(drive, shot, 7).points[0].y, 3);
  shot.view = View::kBlank;
  EXPECT_TRUE(MakeScan(drive, shot, 7).points.empty());
}

TEST(FindScenarios, TakesBeginningsOfNames) {
  const auto blank = FindScenarios({"blank"});
  ASSERT_TRUE(blank.ok());
  EXPECT_EQ(blank->size(), 2u);
  EXPECT_EQ(FindScenarios({})->size(), Scenarios().size());
  EXPECT_THAT(FindScenarios({"museum", "moon"}).status().message(), HasSubstr("\"moon\""));
}

TEST(Scenarios, BlankScansFallIntoATurn) {
  const auto scenario = FindScenarios({"blank_museum"});
  const auto drive = (*scenario)[0].make({}, 3);
  ASSERT_TRUE(drive.ok()) << drive.status();
  const int end = drive->trouble_ends, begin = end - 20;
  for (int i = 0; i < static_cast<int>(drive->shots.size()); ++i) {
    ASSERT_EQ(drive->shots[i].view == View::kBlank, i >= begin && i < end) << i;
  }
  const Pose turned = drive->truth_of(begin - 1).Inverse() * drive->truth_of(end - 1);
  EXPECT_GE(std::abs(turned.Yaw()), 2 * 30 * std::numbers::pi / 180);
}

TEST(Scenarios, LapsRepeatTheOneThatWasRecorded) {
  const auto scenario = FindScenarios({"laps"});
  const auto drive = (*scenario)[0].make({.seconds = 200}, 1);
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_EQ(drive->shots.size(), 2000u);
  for (size_t i = drive->lap_begins; i + drive->lap_shots < drive->shots.size(); ++i) {
    ASSERT_EQ(drive->shots[i].turn, drive->shots[i + drive->lap_shots].turn);
  }
  // From the end of a lap to its beginning is a step like any other.
  const int last = drive->lap_begins + drive->lap_shots - 1;
  const Pose over = drive->truth_of(last).Inverse() * drive->truth_of(drive->lap_begins);
  const Pose before = drive->truth_of(last - 1).Inverse() * drive->truth_of(last);
  EXPECT_LT((over.translation() - before.translation()).norm(), 0.02);
}

}  // namespace
}  // namespace isthmus::bench
