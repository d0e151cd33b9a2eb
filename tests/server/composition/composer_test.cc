#include "server/composition/composer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <thread>

#include "server/composition/tiles/tiled_map.h"
#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<TilePtr>& TilesOf(const std::shared_ptr<const ComposedMap>& map,
                                    uint32_t component = 0) {
  return dynamic_cast<const TiledMap&>(*map).tiles(component);
}

const Box kRoom = MakeBox({-25, -15, -1}, {25, 15, 3});

// Two robots of two submaps each, all over the room.
std::vector<LaidSubmap> RandomMap(unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<LaidSubmap> submaps;
  for (const char* robot : {"alice", "bob"}) {
    for (uint32_t index = 0; index < 3; ++index) {
      const Pose T_map_submap = Pose::FromXyzRpy(rng() % 5, rng() % 5, 0.3, 0.02, -0.01, rng() % 6);
      submaps.push_back(MakeSubmap(robot, index, RandomPoints(&rng, 3000, kRoom), T_map_submap));
    }
  }
  return submaps;
}

TEST(Composer, NothingGivesAnEmptyMap) {
  Composer composer({});
  const auto map = Compose(&composer, 7, {});
  EXPECT_EQ(map->revision(), 7);
  EXPECT_EQ(map->component_count(), 0u);
  EXPECT_EQ(map->point_count(0), 0u);
  EXPECT_TRUE(map->bounds(0).empty());
  EXPECT_THAT(map->robots(), IsEmpty());
  EXPECT_THAT(ReadAll(*map), IsEmpty());
}

TEST(Composer, PointLandsWhereItsPosesSay) {
  Submap submap;
  submap.id = {SessionId("alice-1"), 0};
  submap.robot = RobotId("alice");
  submap.T_odom_submap = Pose::FromXyzRpy(7, 7, 7, 0, 0, 0);  // Is not looked at.
  submap.keyframes.resize(1);
  submap.points = {At(1, 0, 0.5, 42)};
  Composer composer({});
  const Pose T_map_submap = Pose::FromXyzRpy(10, 100, 0, 0, 0, std::numbers::pi / 2);
  const auto map = Compose(&composer, 1, {{std::make_shared<Submap>(submap), 0, T_map_submap}});
  const auto points = ReadAll(*map);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].x, 10, 1e-4);
  EXPECT_NEAR(points[0].y, 101, 1e-4);
  EXPECT_NEAR(points[0].z, 0.5, 1e-4);
  EXPECT_FLOAT_EQ(points[0].intensity, 42);
  EXPECT_EQ(points[0].robot, 0u);
}

TEST(Composer, VoxelHoldsTheMeanPerRobot) {
  Composer composer({});
  const auto map = Compose(
      &composer, 1,
      {MakeSubmap("bob", 0, {At(.01, .01, .01, 2), At(.03, .01, .01, 4), At(.05, .01, .01, 6)}),
       MakeSubmap("bob", 1, {At(.07, .01, .01, 8)}),
       MakeSubmap("alice", 0, {At(.09, .01, .01, 1)})});
  EXPECT_THAT(map->robots(), ElementsAre(RobotId("alice"), RobotId("bob")));
  const auto points = ReadAll(*map);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].robot, 0u);
  EXPECT_NEAR(points[0].x, .09, 1e-6);
  EXPECT_EQ(points[1].robot, 1u);
  EXPECT_NEAR(points[1].x, .04, 1e-6);  // Every measured point counts the same.
  EXPECT_NEAR(points[1].intensity, 5, 1e-5);
}

TEST(Composer, AtMostOnePointPerVoxelAndRobot) {
  Composer composer({.tile_m = 7.77, .voxel_m = 0.5});  // Tiles that are no multiple of a voxel.
  const auto points = ReadAll(*Compose(&composer, 1, RandomMap(1)));
  std::set<std::tuple<int, int, int, uint32_t>> voxels;
  for (const MapPoint& p : points) {
    voxels.emplace(std::floor(p.x / .5), std::floor(p.y / .5), std::floor(p.z / .5), p.robot);
  }
  EXPECT_EQ(voxels.size(), points.size());
  EXPECT_GT(points.size(), 5000u);
}

TEST(Composer, EveryPointIsRepresentedNearby) {
  const auto submaps = RandomMap(2);
  Composer composer({.voxel_m = 0.2});
  const auto points = ReadAll(*Compose(&composer, 1, submaps));
  const double reach = 2 * 0.2 * std::sqrt(3);  // Thinned on the submap's grid, then on the map's.
  for (size_t i = 0; i < submaps[0].submap->points.size(); i += 100) {
    const Eigen::Vector3d p =
        submaps[0].T_map_submap * submaps[0].submap->points[i].Position().cast<double>().eval();
    double nearest = std::numeric_limits<double>::infinity();
    for (const MapPoint& q : points) {
      if (q.robot == 0) nearest = std::min(nearest, (p - Eigen::Vector3d(q.x, q.y, q.z)).norm());
    }
    EXPECT_LT(nearest, reach);
  }
}

TEST(Composer, SameAgainRemakesNothing) {
  Composer composer({});
  const auto first = Compose(&composer, 1, RandomMap(3));
  const int all = composer.last_tiles_remade();
  EXPECT_EQ(static_cast<size_t>(all), TilesOf(first).size());
  const auto second = Compose(&composer, 2, RandomMap(3));  // Equal content, other objects.
  EXPECT_EQ(composer.last_tiles_remade(), 0);
  EXPECT_EQ(TilesOf(first), TilesOf(second));
  EXPECT_EQ(second->revision(), 2);
}

TEST(Composer, OnlyTouchedTilesAreRemade) {
  Composer composer({.tile_m = 10});
  std::vector<LaidSubmap> submaps{MakeSubmap("alice", 0, {At(5, 5, 0), At(15, 5, 0)}),
                                  MakeSubmap("bob", 0, {At(16, 6, 0), At(25, 5, 0)})};
  const auto before = Compose(&composer, 1, submaps);
  ASSERT_EQ(TilesOf(before).size(), 3u);
  submaps.push_back(MakeSubmap("bob", 1, {At(26, 6, 0)}));
  const auto after = Compose(&composer, 2, submaps);
  EXPECT_EQ(composer.last_tiles_remade(), 1);
  EXPECT_EQ(TilesOf(before)[0], TilesOf(after)[0]);
  EXPECT_EQ(TilesOf(before)[1], TilesOf(after)[1]);
  EXPECT_NE(TilesOf(before)[2], TilesOf(after)[2]);
  EXPECT_EQ(before->point_count(0), 4u);  // The old map stays as it was.
  EXPECT_EQ(after->point_count(0), 5u);
}

TEST(Composer, MovedSubmapLeavesNoGhosts) {
  Composer composer({.tile_m = 10});
  std::mt19937 rng(4);
  const auto alice = MakeSubmap("alice", 0, RandomPoints(&rng, 2000, kRoom));
  auto bob = MakeSubmap("bob", 0, RandomPoints(&rng, 2000, kRoom));
  Compose(&composer, 1, {alice, bob});
  bob.T_map_submap = Pose::FromXyzRpy(200, 0, 0, 0, 0, 1);
  const auto map = Compose(&composer, 2, {alice, bob});
  Region old_place;
  old_place.box = MakeBox({-50, -50, -5}, {50, 50, 5});
  for (const MapPoint& p : ReadAll(*map, old_place)) EXPECT_EQ(p.robot, 0u);
  Composer fresh({.tile_m = 10});
  EXPECT_EQ(Sorted(ReadAll(*map)), Sorted(ReadAll(*Compose(&fresh, 2, {alice, bob}))));
}

TEST(Composer, RemovedSubmapIsGone) {
  Composer composer({});
  auto submaps = RandomMap(5);
  Compose(&composer, 1, submaps);
  submaps.erase(submaps.begin() + 3, submaps.end());  // All of bob.
  const auto map = Compose(&composer, 2, submaps);
  EXPECT_THAT(map->robots(), ElementsAre(RobotId("alice")));
  Composer fresh({});
  EXPECT_EQ(Sorted(ReadAll(*map)), Sorted(ReadAll(*Compose(&fresh, 2, submaps))));
  const auto empty = Compose(&composer, 3, {});
  EXPECT_EQ(empty->component_count(), 0u);
  EXPECT_THAT(ReadAll(*empty), IsEmpty());
}

TEST(Composer, SmallMovesWaitUntilTheyAddUp) {
  Composer composer({.min_move_m = 0.01});
  auto submap = MakeSubmap("alice", 0, {At(1, 1, 1), At(9, 1, 1)});
  Compose(&composer, 1, {submap});
  submap.T_map_submap = Pose(Eigen::Vector3d(.006, 0, 0));
  Compose(&composer, 2, {submap});
  EXPECT_EQ(composer.last_tiles_remade(), 0);
  submap.T_map_submap = Pose(Eigen::Vector3d(.012, 0, 0));
  Compose(&composer, 3, {submap});
  EXPECT_EQ(composer.last_tiles_remade(), 1);
  // A turn that the origin does not feel moves the far end.
  submap.T_map_submap = Pose::FromXyzRpy(.012, 0, 0, 0, 0, .002);
  Compose(&composer, 4, {submap});
  EXPECT_EQ(composer.last_tiles_remade(), 1);
}

TEST(Composer, ReusedIdWithOtherContentIsSeen) {
  Composer composer({});
  Compose(&composer, 1, {MakeSubmap("alice", 0, {At(1, 1, 1)})});
  const auto map = Compose(&composer, 2, {MakeSubmap("alice", 0, {At(5, 5, 5), At(6, 6, 6)})});
  EXPECT_EQ(map->point_count(0), 2u);
}

TEST(Composer, ComponentsAreMapsOfTheirOwn) {
  Composer composer({});
  auto alice = MakeSubmap("alice", 0, {At(1, 1, 1)}, Pose(), 0);
  auto bob = MakeSubmap("bob", 0, {At(1, 1, 1), At(2, 2, 2)}, Pose(), 1);
  const auto apart = Compose(&composer, 1, {alice, bob});
  EXPECT_EQ(apart->component_count(), 2u);
  EXPECT_EQ(apart->point_count(0), 1u);
  EXPECT_EQ(apart->point_count(1), 2u);
  Region second;
  second.component = 1;
  for (const MapPoint& p : ReadAll(*apart, second)) EXPECT_EQ(p.robot, 1u);

  bob.component = 0;
  const auto joined = Compose(&composer, 2, {alice, bob});
  EXPECT_EQ(joined->component_count(), 1u);
  EXPECT_EQ(joined->point_count(0), 3u);
}

TEST(Composer, RenumberedComponentsKeepTheirTiles) {
  Composer composer({});
  auto alice = MakeSubmap("alice", 0, {At(1, 1, 1)}, Pose(), 0);
  auto bob = MakeSubmap("bob", 0, {At(1, 1, 1), At(2, 2, 2)}, Pose(), 1);
  const auto before = Compose(&composer, 1, {alice, bob});
  std::swap(alice.component, bob.component);
  const auto after = Compose(&composer, 2, {alice, bob});
  EXPECT_EQ(composer.last_tiles_remade(), 0);
  EXPECT_EQ(TilesOf(before, 0), TilesOf(after, 1));
  EXPECT_EQ(TilesOf(before, 1), TilesOf(after, 0));
  EXPECT_EQ(after->point_count(0), 2u);
}

TEST(Composer, NewRobotDoesNotRemakeTheOthersTiles) {
  Composer composer({});
  const auto bob = MakeSubmap("bob", 0, {At(1, 1, 1)});
  Compose(&composer, 1, {bob});
  const auto map = Compose(&composer, 2, {bob, MakeSubmap("alice", 0, {At(-1, 1, 1)})});
  EXPECT_EQ(composer.last_tiles_remade(), 1);
  EXPECT_THAT(map->robots(), ElementsAre(RobotId("alice"), RobotId("bob")));
  for (const MapPoint& p : ReadAll(*map)) EXPECT_EQ(p.robot, p.x > 0 ? 1u : 0u);
}

TEST(Composer, IncrementalEqualsFromScratch) {
  std::mt19937 rng(6);
  auto submaps = RandomMap(6);
  Composer composer({.tile_m = 8, .voxel_m = 0.3, .min_move_m = 0});
  std::vector<LaidSubmap> in_map;
  for (int step = 0; step < 30; ++step) {
    Stir(submaps, {9, 3, 4}, &rng, &in_map);
    std::shuffle(in_map.begin(), in_map.end(), rng);
    const auto map = Compose(&composer, step, in_map);
    Composer fresh({.tile_m = 8, .voxel_m = 0.3, .min_move_m = 0});
    const auto expected = Compose(&fresh, step, in_map);
    ASSERT_EQ(map->robots(), expected->robots());
    for (uint32_t component = 0; component < 2; ++component) {
      Region region;
      region.component = component;
      ASSERT_EQ(Sorted(ReadAll(*map, region)), Sorted(ReadAll(*expected, region)));
      EXPECT_EQ(map->point_count(component), expected->point_count(component));
    }
    ExpectSameTiles(*map, *expected);
  }
}

TEST(Composer, WhatCannotBeReadIsMissingUntilItCan) {
  Composer composer({});
  const std::vector<LaidSubmap> there{MakeSubmap("alice", 0, {At(1, 1, 1)})};
  auto all = there;
  all.push_back(MakeSubmap("bob", 0, {At(2, 2, 2)}));
  const auto without = *composer.Compose(1, Placed(all), ReaderOf(there));
  EXPECT_EQ(without->missing_submaps(), 1u);
  EXPECT_EQ(without->point_count(0), 1u);
  const auto with = Compose(&composer, 2, all);
  EXPECT_EQ(with->missing_submaps(), 0u);
  EXPECT_EQ(with->point_count(0), 2u);
}

// The session was deleted and its name used again after the map was placed.
TEST(Composer, AnotherSubmapThanWasPlacedIsMissing) {
  Composer composer({});
  const auto map =
      *composer.Compose(1, Placed({MakeSubmap("alice", 0, {At(1, 1, 1)})}),
                        ReaderOf({MakeSubmap("alice", 0, {At(2, 2, 2), At(3, 3, 3)})}));
  EXPECT_EQ(map->missing_submaps(), 1u);
  EXPECT_EQ(map->point_count(0), 0u);
}

TEST(Composer, SubmapsAreReadOnce) {
  Composer composer({});
  const auto submaps = RandomMap(8);
  int reads = 0;
  for (int64_t revision = 1; revision <= 2; ++revision) {
    EXPECT_TRUE(composer.Compose(revision, Placed(submaps), ReaderOf(submaps, &reads)).ok());
  }
  EXPECT_EQ(reads, static_cast<int>(submaps.size()));
}

// Readers keep a map while the next ones are made; ThreadSanitizer watches what they share.
TEST(Composer, MapsCanBeReadWhileNewerOnesAreMade) {
  auto submaps = RandomMap(7);
  Composer composer({.tile_m = 8});
  const auto kept = Compose(&composer, 0, submaps);
  const auto expected = Sorted(ReadAll(*kept));
  std::thread reader([&] {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(Sorted(ReadAll(*kept)), expected);
  });
  for (int revision = 1; revision <= 20; ++revision) {
    submaps[revision % submaps.size()].T_map_submap = Pose(Eigen::Vector3d(revision, 0, 0));
    Compose(&composer, revision, submaps);
  }
  reader.join();
}

TEST(Composer, UnusableInputAddsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  Composer composer({.tile_m = nan, .voxel_m = -1, .min_move_m = nan});
  const auto map =
      Compose(&composer, 1,
              {LaidSubmap{}, MakeSubmap("alice", 0, {At(nan, 0, 0), At(0, inf, 0), At(1e30, 0, 0)}),
               MakeSubmap("bob", 0, {At(1, 1, 1)}, Pose(Eigen::Vector3d(nan, 0, 0))),
               MakeSubmap("carol", 0, {}), MakeSubmap("dave", 0, {At(1, 1, 1)})});
  EXPECT_EQ(map->point_count(0), 1u);
}

}  // namespace
}  // namespace isthmus::composition
