#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "lab/bench/merging/drive_cache.h"
#include "lab/bench/merging/recorded_parts.h"
#include "lab/bench/merging/scenario_list.h"
#include "lab/bench/merging/temporary_folder.h"

namespace isthmus::bench {
namespace {

DriveOptions Short() { return {.world = "twins", .seed = 2, .seconds = 1}; }

TEST(DriveOptions, KeysTellDrivesApart) {
  DriveOptions other = Short();
  other.robot = 1;
  EXPECT_NE(Short().Key(), other.Key());
  other = Short();
  other.cars = 3;
  EXPECT_NE(Short().Key(), other.Key());
  other = Short();
  other.sensor = "hdl64";
  EXPECT_NE(Short().Key(), other.Key());
  EXPECT_EQ(Short().Ground(), other.Ground());
  other = Short();
  other.truth = simulation::Truth::kMoving;
  EXPECT_NE(Short().Key(), other.Key());
  const std::string moving = other.Key();
  other.truth = simulation::Truth::kClass;
  EXPECT_NE(Short().Key(), other.Key());
  EXPECT_NE(moving, other.Key());
}

TEST(DriveOptions, LapsAndSpeedHaveKeysOfTheirOwn) {
  EXPECT_EQ(Short().Key(), "twins-2-1s-0of2-vlp16");
  DriveOptions around = Short();
  around.laps = 3;
  EXPECT_EQ(around.Key(), "twins-2-1s-0of2-vlp16-laps3");
  around.speed_mps = 0.5;
  EXPECT_EQ(around.Key(), "twins-2-1s-0of2-vlp16-laps3-0.5mps");
}

TEST(SimulateDrive, ComesBackToWhereItsLapsBegan) {
  DriveOptions around = Short();
  around.seconds = 10;
  around.laps = 2;
  const auto once = SimulateDrive(Short()), twice = SimulateDrive(around);
  around.laps = 3;
  const auto thrice = SimulateDrive(around);
  ASSERT_TRUE(twice.ok() && thrice.ok()) << twice.status() << thrice.status();
  const auto shots = [](const auto& grounded) {
    return static_cast<int>(grounded->drive.shots.size());
  };
  const int lap = shots(thrice) - shots(twice), end = shots(twice) - 1;
  ASSERT_GT(lap, 100);
  const auto at = [&](int turn) { return thrice->drive.truth_of(turn).translation(); };
  EXPECT_LT((at(end) - at(end - lap)).norm(), 1e-6);
  EXPECT_GT((at(end) - at(end - lap / 2)).norm(), 1);
}

TEST(SimulateDrive, IsNoFasterThanItMayBe) {
  DriveOptions slow = {.world = "museum", .seed = 1, .seconds = 10};
  slow.speed_mps = 0.3;
  const auto drive = SimulateDrive(slow);
  ASSERT_TRUE(drive.ok()) << drive.status();
  double path_length = 0;
  for (int turn = 1; turn < 100; ++turn) {
    path_length +=
        (drive->drive.truth_of(turn).translation() - drive->drive.truth_of(turn - 1).translation())
            .norm();
  }
  EXPECT_GT(path_length, 1);
  EXPECT_LT(path_length, 0.3 * 10 * 1.05);
}

TEST(DriveCache, KeepsWhatTheServerMadeOfADrive) {
  const TemporaryFolder folder;
  int made = 0;
  const auto get = [&] {
    DriveCache cache(folder.path(), {});
    return cache.Get("drive", [&] {
      ++made;
      return SimulateDrive(Short());
    });
  };
  const auto first = get(), again = get();
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(made, 1);
  EXPECT_EQ(again->ground, "twins-2");
  EXPECT_EQ(again->lost_scans, 0);
  ASSERT_EQ(again->poses.size(), 10u);
  ASSERT_EQ(again->submaps.size(), 1u);
  EXPECT_GT(again->submaps[0]->points.size(), 1000u);
  EXPECT_LT(again->OdometryRmse(), 0.1);
  ASSERT_NE(again->FindPose(4), nullptr);
  EXPECT_EQ(again->FindPose(4)->sequence, 4u);
  EXPECT_EQ(again->FindPose(11), nullptr);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos);
  }
}

TEST(DriveCache, SaysWhatCannotBeSimulated) {
  DriveOptions moon = Short();
  moon.world = "moon";
  const auto robot = DriveCache("", {}).Get(moon);
  EXPECT_EQ(robot.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Rename, CallsSubmapsAfterTheirRobot) {
  DrivenRobot robot;
  robot.submaps.push_back(std::make_shared<Submap>());
  Rename(&robot, "robot_b");
  EXPECT_EQ(robot.session.id.value(), "robot_b-1");
  EXPECT_EQ(robot.submaps[0]->id.session, robot.session.id);
  EXPECT_EQ(robot.submaps[0]->robot.value(), "robot_b");
}

TEST(Backwards, MirrorsOrderTimesAndTruth) {
  const auto grounded = SimulateDrive(Short());
  ASSERT_TRUE(grounded.ok());
  const Drive part = PartOf(grounded->drive, 2, 5);
  ASSERT_EQ(part.shots.size(), 4u);
  const auto backwards = Backwards(part);
  ASSERT_TRUE(backwards.ok()) << backwards.status();
  ASSERT_EQ(backwards->shots.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const Scan scan = MakeScan(*backwards, backwards->shots[i], 1);
    const Scan forwards = MakeScan(part, part.shots[3 - i], 1);
    EXPECT_EQ(scan.end_stamp_ns, part.shots[i].end_stamp_ns);
    ASSERT_TRUE(scan.has_ring && scan.has_time);
    // The first measurement comes last.
    const ScanPoint &last = scan.points.back(), &first = forwards.points.front();
    EXPECT_NEAR(last.time, -0.1f - first.time, 1e-4);
    EXPECT_LE(scan.points.front().time, last.time);
    // It ends where the turn before it ended.
    const Pose truth = backwards->truth_of(backwards->shots[i].turn);
    EXPECT_LT((truth.translation() - part.truth_of(4 - i).translation()).norm(), 1e-12);
  }
}

TEST(MergingScenarios, AreFoundByName) {
  const auto found = FindMergingScenarios({"campus_4", "museum"});
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->size(), 2u);
  EXPECT_EQ((*found)[0].robots.size(), 4u);
  EXPECT_EQ((*found)[1].robots.size(), 2u);
  EXPECT_FALSE(FindMergingScenarios({"moon"}).ok());
}

}  // namespace
}  // namespace isthmus::bench
