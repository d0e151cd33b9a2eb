#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/angles.h"
#include "server/composition/changes/changed_points.h"
#include "server/composition/changes/volumes.h"
#include "tests/server/composition/gallery.h"

namespace isthmus::composition {
namespace {

using ::testing::ElementsAre;

const Thing kPallet = MakeBox({2.2, 1.1, 0}, {3.4, 1.9, 1.1});
const Thing kElsewhere = MakeBox({-4.4, -3.9, 0}, {-3.2, -3.1, 1.1});
// Stands between the drives and the wall behind it.
const Thing kScreen = MakeBox({-9, 4.0, 0}, {9, 4.1, 4});

using Things = std::vector<Thing>;

auto AllAlong(const Things& things) {
  return [things](int) { return things; };
}

// Two drives of a day through the hall, as one robot's.
std::vector<LaidSubmap> Day(const std::string& robot, const Things& things) {
  return {Drive(robot, 0, 0, AllAlong(things)), Drive(robot, 1, -1.5, AllAlong(things))};
}

struct Outcome {
  absl::Status status;
  std::vector<ChangedVolume> volumes;
};

Outcome Changes(
    const std::vector<LaidSubmap>& before, const std::vector<LaidSubmap>& after,
    const Region& region = {}, const KeepOn& keep_on = [] { return true; }) {
  std::vector<LaidSubmap> all = before;
  all.insert(all.end(), after.begin(), after.end());
  std::vector<ComparedSubmap> submaps;
  for (const PlacedSubmap& placed : Placed(all)) {
    submaps.push_back({placed, submaps.size() >= before.size()});
  }
  const auto points = FindChangedPoints(submaps, ReaderOf(all), region, keep_on);
  if (!points.ok()) return {points.status(), {}};
  return {absl::OkStatus(), MakeVolumes(*points, submaps, {.wants_points = true})};
}

// The volume's box, to within what is not seen of a thing: its far sides, its foot.
void ExpectIs(const ChangedVolume& volume, bool came, const Thing& thing) {
  EXPECT_EQ(volume.came, came);
  const Eigen::Vector3d middle = 0.5 * (thing.min + thing.max), size = thing.max - thing.min;
  EXPECT_LT((volume.T_map_box.translation() - middle).norm(), 0.45);
  EXPECT_LT((volume.size - size).norm(), 0.6) << volume.size.transpose();
  EXPECT_GT(volume.probability, 0.9);
  EXPECT_EQ(volume.places.size(), volume.points);
}

TEST(Changes, WhatWasMovedWentAndCame) {
  const auto found = Changes(Day("alice", {kPallet}), Day("bob", {kElsewhere}));
  ASSERT_TRUE(found.status.ok()) << found.status;
  ASSERT_EQ(found.volumes.size(), 2u);
  const size_t went = found.volumes[0].came ? 1 : 0;
  ExpectIs(found.volumes[went], false, kPallet);
  ExpectIs(found.volumes[1 - went], true, kElsewhere);
  EXPECT_THAT(found.volumes[went].seen_by, ElementsAre(RobotId("alice")));
  EXPECT_THAT(found.volumes[went].missed_by, ElementsAre(RobotId("bob")));
  EXPECT_THAT(found.volumes[1 - went].seen_by, ElementsAre(RobotId("bob")));
  EXPECT_LT(found.volumes[went].seen_first_ns, found.volumes[went].seen_last_ns);
}

TEST(Changes, NothingChangedWhereNothingMoved) {
  EXPECT_TRUE(Changes(Day("alice", {kPallet}), Day("bob", {kPallet})).volumes.empty());
}

// The error that placement leaves between two days, in any direction.
TEST(Changes, WallsThatLieWrongDoNotMove) {
  for (const Eigen::Vector3d& off :
       {Eigen::Vector3d(0.15, -0.1, 0.03), Eigen::Vector3d(-0.05, 0.19, -0.03)}) {
    auto day = Day("bob", {kPallet});
    for (LaidSubmap& laid : day) {
      laid.T_map_submap = Pose::FromXyzRpy(off.x(), off.y(), off.z(), 0, 0, 0.3 * kRadPerDeg);
    }
    EXPECT_TRUE(Changes(Day("alice", {kPallet}), day).volumes.empty()) << off.transpose();
  }
}

// A sheet beside a surface that is still there, though farther than is usual.
TEST(Changes, AWallThatDriftedFarIsNoChange) {
  auto day = Day("bob", {});
  for (LaidSubmap& laid : day) laid.T_map_submap = Pose::FromXyzRpy(0.36, 0, 0, 0, 0, 0);
  EXPECT_TRUE(Changes(Day("alice", {}), day).volumes.empty());
}

TEST(Changes, WhoWalksByIsNoChange) {
  const auto passes = [](int k) { return k == 3 ? Things{kPallet} : Things{}; };
  const std::vector<LaidSubmap> alice = {Drive("alice", 0, 0, passes)};
  EXPECT_TRUE(Changes(alice, Day("bob", {})).volumes.empty());
  // Also where nobody of the day looked there afterwards.
  const auto at_the_end = [](int k) { return k >= 7 ? Things{kPallet} : Things{}; };
  EXPECT_TRUE(Changes({Drive("alice", 0, 0, at_the_end)}, Day("bob", {})).volumes.empty());
}

TEST(Changes, WhatTheOtherDayCouldNotSeeIsUnknown) {
  const Thing behind = MakeBox({2.2, 5.1, 0}, {3.4, 5.9, 1.1});
  EXPECT_FALSE(Changes(Day("alice", {behind}), Day("bob", {})).volumes.empty());
  // The screen came; the things behind it may be there still.
  for (const ChangedVolume& volume :
       Changes(Day("alice", {behind}), Day("bob", {kScreen})).volumes) {
    EXPECT_TRUE(volume.came);
  }
}

TEST(Changes, RegionsCutOut) {
  Region region;
  region.box = MakeBox({-6, -6, -1}, {0, 0, 5});
  const auto found = Changes(Day("alice", {kPallet}), Day("bob", {kElsewhere}), region);
  ASSERT_EQ(found.volumes.size(), 1u);
  ExpectIs(found.volumes[0], true, kElsewhere);
}

TEST(Changes, TheOrderOfSubmapsDoesNotMatter) {
  auto before = Day("alice", {kPallet}), after = Day("bob", {kElsewhere});
  const auto one = Changes(before, after);
  std::ranges::reverse(before);
  std::ranges::reverse(after);
  const auto other = Changes(before, after);
  ASSERT_EQ(one.volumes.size(), other.volumes.size());
  for (size_t i = 0; i < one.volumes.size(); ++i) {
    EXPECT_EQ(one.volumes[i].points, other.volumes[i].points);
    EXPECT_EQ(one.volumes[i].size, other.volumes[i].size);
  }
}

TEST(Changes, EndsWhenTold) {
  int asked = 0;
  const auto found =
      Changes(Day("alice", {kPallet}), Day("bob", {}), {}, [&] { return ++asked < 3; });
  EXPECT_EQ(found.status.code(), absl::StatusCode::kCancelled);
}

// One that cannot be read is left out; the other of the day is asked.
TEST(Changes, MissingSubmapsAreLeftOut) {
  auto day = Day("bob", {});
  std::vector<ComparedSubmap> submaps;
  const auto alice = Day("alice", {kPallet});
  std::vector<LaidSubmap> all = {alice[0], day[0], day[1]};
  for (const PlacedSubmap& placed : Placed(all)) submaps.push_back({placed, !submaps.empty()});
  const auto points =
      FindChangedPoints(submaps, ReaderOf({alice[0], day[1]}), {}, [] { return true; });
  ASSERT_TRUE(points.ok()) << points.status();
  EXPECT_EQ(MakeVolumes(*points, submaps, {}).size(), 1u);
}

}  // namespace
}  // namespace isthmus::composition
