#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>

#include "server/composition/composer.h"
#include "tests/server/composition/gallery.h"
#include "tests/server/composition/test_maps.h"
#include "tests/server/composition/tiles/failing_map_file.h"

namespace isthmus::composition {
namespace {

const ComposerOptions kDropping = {.drop_gone = true};
const Thing kPerson = MakeBox({3.0, 0.8, 0}, {3.4, 1.2, 1.75});
const Thing kPole = MakeBox({-4.03, 1.97, 0}, {-3.97, 2.03, 4});

std::vector<Thing> Nothing(int) { return {}; }
std::vector<Thing> Always(int) { return {kPerson}; }

// Points within 3 cm of the thing and not on the floor.
int PointsOn(const Thing& thing, const std::vector<MapPoint>& points) {
  Box around = thing;
  around.min.array() -= 0.03;
  around.max.array() += 0.03;
  around.min.z() = 0.15;
  return static_cast<int>(std::ranges::count_if(
      points, [&](const MapPoint& p) { return around.Contains(Eigen::Vector3d(p.x, p.y, p.z)); }));
}

int PointsOn(const Thing& thing, const ComposedMap& map) { return PointsOn(thing, ReadAll(map)); }

TEST(VisibilityFilter, WhoWalksByLeavesAndNothingElse) {
  const auto walker = [](int k) { return k == 2 ? Always(k) : Nothing(k); };
  const std::vector<LaidSubmap> drives = {Drive("alice", 0, 0, walker)};
  Composer keeps({}), drops(kDropping);
  const auto all = Compose(&keeps, 1, drives), map = Compose(&drops, 1, drives);
  const int before = PointsOn(kPerson, *all);
  ASSERT_GT(before, 40);
  EXPECT_LT(PointsOn(kPerson, *map), before / 20);
  const auto dropped = ReadAll(*map->dropped());
  EXPECT_EQ(PointsOn(kPerson, dropped) + PointsOn(kPerson, *map), before);
  EXPECT_EQ(PointsOn(kPerson, dropped), static_cast<int>(dropped.size()));
  EXPECT_EQ(map->point_count(0) + dropped.size(), all->point_count(0));
  EXPECT_EQ(all->dropped(), nullptr);
}

TEST(VisibilityFilter, WhatStandsStays) {
  const auto pole = [](int) { return std::vector<Thing>{kPole}; };
  const std::vector<LaidSubmap> drives = {Drive("alice", 0, 0, pole), Drive("bob", 0, -2, pole),
                                          Drive("bob", 1, 3, pole)};
  Composer composer(kDropping);
  const auto map = Compose(&composer, 1, drives);
  EXPECT_GT(PointsOn(kPole, *map), 20);
  EXPECT_EQ(map->dropped()->point_count(0), 0u);
}

TEST(VisibilityFilter, WhatWasTakenAwayLeavesOnceOthersLookedThrough) {
  std::vector<LaidSubmap> drives = {Drive("alice", 0, 0, Always)};
  Composer composer(kDropping);
  const int before = PointsOn(kPerson, *Compose(&composer, 1, drives));
  ASSERT_GT(before, 40);
  drives.push_back(Drive("alice", 1, -2, Nothing));
  drives.push_back(Drive("bob", 0, -1, Nothing));
  EXPECT_LT(PointsOn(kPerson, *Compose(&composer, 2, drives)), before / 10);
  drives.resize(1);  // The other drives were deleted.
  EXPECT_EQ(PointsOn(kPerson, *Compose(&composer, 3, drives)), before);
}

LaidSubmap HoursLater(LaidSubmap laid, int hours) {
  auto submap = std::make_shared<Submap>(*laid.submap);
  submap->first_stamp_ns += hours * int64_t{3'600'000'000'000};
  submap->last_stamp_ns += hours * int64_t{3'600'000'000'000};
  laid.submap = submap;
  return laid;
}

// A pallet that is put down: looks through its place from before say nothing of it, later ones do.
TEST(VisibilityFilter, WhatCameStaysUntilOthersLookThrough) {
  std::vector<LaidSubmap> drives = {HoursLater(Drive("bob", 1, -1, Always), 5)};
  Composer composer(kDropping);
  const int before = PointsOn(kPerson, *Compose(&composer, 1, drives));
  ASSERT_GT(before, 40);
  for (int i = 0; i < 4; ++i) {
    drives.push_back(Drive("alice", static_cast<uint32_t>(i), 0.5 * i - 2, Nothing));
  }
  EXPECT_GE(PointsOn(kPerson, *Compose(&composer, 2, drives)), 19 * before / 20);
  drives.push_back(HoursLater(Drive("alice", 4, -2, Nothing), 9));
  drives.push_back(HoursLater(Drive("bob", 2, 0, Nothing), 9));
  EXPECT_LT(PointsOn(kPerson, *Compose(&composer, 3, drives)), before / 10);
}

// A person who walks by leaves nevertheless.
TEST(VisibilityFilter, WhoWalksByLeavesByLooksFromBefore) {
  const auto walker = [](int k) { return k == 8 ? Always(k) : Nothing(k); };
  std::vector<LaidSubmap> drives = {HoursLater(Drive("bob", 1, -1, walker), 5)};
  Composer composer(kDropping);
  const int alone = PointsOn(kPerson, *Compose(&composer, 1, drives));
  drives.push_back(Drive("alice", 0, 0, Nothing));
  drives.push_back(Drive("alice", 1, -2, Nothing));
  EXPECT_LE(PointsOn(kPerson, *Compose(&composer, 2, drives)), alone / 4);
}

TEST(VisibilityFilter, OtherFloorsAndComponentsHaveNoSay) {
  std::vector<LaidSubmap> drives = {Drive("alice", 0, 0, Always), Drive("bob", 0, -1, Nothing),
                                    Drive("bob", 1, -2, Nothing)};
  drives[1].component = drives[2].component = 1;
  Composer composer(kDropping);
  const auto map = Compose(&composer, 1, drives);
  EXPECT_GT(PointsOn(kPerson, *map), 40);
  drives[1].component = drives[2].component = 0;
  for (size_t i : {1, 2}) drives[i].T_map_submap = Pose(Eigen::Vector3d(0, 0, 60));
  EXPECT_GT(PointsOn(kPerson, *Compose(&composer, 2, drives)), 40);
}

// The history of submaps does not matter, in memory or in the file.
TEST(VisibilityFilter, TheMapIsThatMadeFromNothing) {
  const auto walker = [](int k) { return k % 4 == 1 ? Always(k) : Nothing(k); };
  const std::vector<LaidSubmap> drives = {
      Drive("alice", 0, 0, walker), Drive("alice", 1, -1, Nothing), Drive("bob", 0, -2, Always),
      Drive("bob", 1, 3, Nothing), Drive("carol", 0, -1.5, Nothing)};
  const std::string folder = ::testing::TempDir() + "seen_through";
  std::filesystem::create_directories(folder);
  Composer kept(kDropping);
  Composer spilled({.cache_bytes = 1, .drop_gone = true, .folder = folder});
  std::mt19937 rng(1);
  std::vector<LaidSubmap> in_map;
  uint64_t most_dropped = 0;
  for (int revision = 1; revision <= 12; ++revision) {
    Stir(drives, {.reach_m = 2, .erase_one_in = 4, .other_component_one_in = 6}, &rng, &in_map);
    Composer anew(kDropping);
    const auto expected = Compose(&anew, revision, in_map);
    for (Composer* composer : {&kept, &spilled}) {
      const auto map = Compose(composer, revision, in_map);
      for (uint32_t component : {0u, 1u}) {
        Region region;
        region.component = component;
        ASSERT_EQ(Sorted(ReadAll(*map, region)), Sorted(ReadAll(*expected, region))) << revision;
        ASSERT_EQ(Sorted(ReadAll(*map->dropped(), region)),
                  Sorted(ReadAll(*expected->dropped(), region)));
      }
      most_dropped = std::max(most_dropped, map->dropped()->point_count(0));
    }
  }
  EXPECT_GT(most_dropped, 40u);
}

TEST(VisibilityFilter, WhatTheFileLosesIsAskedAgain) {
  const std::vector<LaidSubmap> drives = {
      Drive("alice", 0, 0, Always), Drive("alice", 1, -2, Nothing), Drive("bob", 0, -1, Nothing)};
  auto file = std::make_shared<FailingMapFile>();
  Composer composer({.cache_bytes = 1, .drop_gone = true}, file), anew(kDropping);
  Compose(&composer, 1, {drives[0]});
  file->fail_reads = true;
  const auto lost = composer.Compose(2, Placed(drives), ReaderOf(drives));
  EXPECT_TRUE(absl::IsDataLoss(lost.status())) << lost.status();
  file->fail_reads = false;
  file->writes_left = 3;
  const auto full = composer.Compose(2, Placed(drives), ReaderOf(drives));
  EXPECT_TRUE(absl::IsResourceExhausted(full.status())) << full.status();
  file->writes_left = std::numeric_limits<int>::max();
  EXPECT_EQ(Sorted(ReadAll(*Compose(&composer, 2, drives))),
            Sorted(ReadAll(*Compose(&anew, 2, drives))));
}

TEST(VisibilityFilter, GoesOnWhereItWasStopped) {
  const std::vector<LaidSubmap> drives = {
      Drive("alice", 0, 0, Always), Drive("alice", 1, -2, Nothing), Drive("bob", 0, -1, Nothing)};
  Composer anew(kDropping);
  const auto expected = Sorted(ReadAll(*Compose(&anew, 1, drives)));
  for (int asked = 1; asked < 60; asked += 3) {
    Composer composer(kDropping);
    int left = asked;
    const auto stopped =
        composer.Compose(1, Placed(drives), ReaderOf(drives), [&](double) { return --left > 0; });
    if (stopped.ok()) break;
    EXPECT_TRUE(absl::IsCancelled(stopped.status()));
    EXPECT_EQ(Sorted(ReadAll(*Compose(&composer, 1, drives))), expected) << asked;
  }
}

}  // namespace
}  // namespace isthmus::composition
