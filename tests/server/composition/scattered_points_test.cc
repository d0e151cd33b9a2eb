// Points strewn over the plane, as no LiDAR measures them but an upload may hold them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "core/stopwatch.h"
#include "server/composition/composer.h"
#include "server/composition/placer.h"
#include "server/composition/tiles/points_by_tile.h"
#include "server/composition/tiles/tile_limit.h"
#include "server/composition/tiles/tiled_map.h"
#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {
namespace {

using ::testing::IsSupersetOf;

constexpr size_t kNoLimit = size_t{1} << 30;
const KeepOn kToTheEnd = [] { return true; };
const Box kHall = MakeBox({-25, -15, -1}, {25, 15, 3});
const Box kCounty = MakeBox({-5000, -5000, 0}, {5000, 5000, 10});

std::vector<WeightedPoint> RandomWeighted(unsigned seed, int count, const Box& box) {
  std::mt19937 rng(seed);
  std::vector<WeightedPoint> points;
  for (const SubmapPoint& p : RandomPoints(&rng, count, box)) points.push_back({p.x, p.y, p.z});
  return points;
}

size_t TilesIn(const std::shared_ptr<const ComposedMap>& map, uint32_t component = 0) {
  return dynamic_cast<const TiledMap&>(*map).tiles(component).size();
}

// Point for point, in the same order.
void ExpectSamePoints(const std::vector<MapPoint>& points, const std::vector<MapPoint>& expected) {
  ASSERT_EQ(points.size(), expected.size());
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(points[i].x, expected[i].x) << i;
    ASSERT_EQ(points[i].y, expected[i].y) << i;
    ASSERT_EQ(points[i].z, expected[i].z) << i;
    ASSERT_EQ(points[i].intensity, expected[i].intensity) << i;
  }
}

TEST(FewestPoints, KeepsTheFullestAndOfEqualsAllOrNone) {
  EXPECT_EQ(FewestPoints({}, 2), 1u);
  EXPECT_EQ(FewestPoints({1, 1}, 2), 1u);
  EXPECT_EQ(FewestPoints({7, 1, 9}, 2), 2u);
  EXPECT_EQ(FewestPoints({7, 9, 3, 7}, 3), 4u);
  EXPECT_EQ(FewestPoints({7, 9, 3, 7}, 2), 8u);
  EXPECT_EQ(FewestPoints({1, 1, 1}, 2), 2u);
}

TEST(TileLimit, ForgetsWhatIsRemoved) {
  TileLimit limit(1);
  const TileKey a{0, 1, 1}, b{0, 2, 2};
  limit.Add(a, 3);
  EXPECT_FALSE(limit.Update());
  limit.Add(b, 1);
  limit.Add(b, 1);
  EXPECT_TRUE(limit.Update());
  EXPECT_TRUE(limit.Stays(a));
  EXPECT_FALSE(limit.Stays(b));
  limit.Remove(a, 2);
  EXPECT_TRUE(limit.Update());
  EXPECT_FALSE(limit.Stays(a));
  EXPECT_TRUE(limit.Stays(b));
  limit.Remove(b, 2);
  EXPECT_TRUE(limit.Update());  // There is room for all again.
  EXPECT_TRUE(limit.Stays(a));
  EXPECT_FALSE(limit.Update());
}

// The rest of composition relies on this: tiles in order, and on each its points in order.
TEST(SortByTile, IsWhatLookingAtEachPointGives) {
  const VoxelGrid grid(0.1);
  const TileLayout layout(5, 0.1);
  const Pose T_map_submap = Pose::FromXyzRpy(100, -30, 1, 0.02, 0.01, 2);
  const std::vector<WeightedPoint> points = RandomWeighted(1, 5000, kHall);
  std::map<TileKey, std::vector<uint32_t>> expected;
  const Placer place(T_map_submap);
  for (uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f at = place(points[i]);
    expected[layout.Find(7, *grid.Find(at.x(), at.y(), at.z()))].push_back(i);
  }
  const PointsByTile sorted =
      *SortByTile(points, 7, T_map_submap, grid, layout, kNoLimit, kToTheEnd);
  ASSERT_EQ(sorted.tiles.size(), expected.size());
  size_t tile = 0;
  for (const auto& [key, indices] : expected) {
    EXPECT_EQ(sorted.tiles[tile], key);
    EXPECT_EQ(sorted.point_count[tile], indices.size());
    std::vector<uint32_t> found;
    for (const PointRun& run : sorted.Of(tile++)) {
      for (uint32_t i = run.begin; i < run.end; ++i) found.push_back(i);
    }
    EXPECT_EQ(found, indices);
  }
  EXPECT_EQ(sorted.left_out, 0u);
}

TEST(SortByTile, KeepsTheFullestTiles) {
  const VoxelGrid grid(0.1);
  const TileLayout layout(20, 0.1);
  std::vector<WeightedPoint> points = RandomWeighted(2, 5000, kCounty);
  const auto room = RandomWeighted(3, 2000, kHall);
  for (size_t i = 0; i < room.size(); ++i) points.insert(points.begin() + 2 * i, room[i]);
  const PointsByTile all = *SortByTile(room, 0, Pose(), grid, layout, kNoLimit, kToTheEnd);
  const PointsByTile sorted = *SortByTile(points, 0, Pose(), grid, layout, 16, kToTheEnd);
  EXPECT_LE(sorted.tiles.size(), 16u);
  EXPECT_THAT(sorted.tiles, IsSupersetOf(all.tiles));
  uint64_t kept = 0;
  for (const uint32_t count : sorted.point_count) kept += count;
  EXPECT_EQ(kept + sorted.left_out, points.size());
}

// Looking through the tiles for every point took 20 s of it, a table takes a twentieth of a second.
TEST(SortByTile, TakesNoLongerForManyTiles) {
  const std::vector<WeightedPoint> points = RandomWeighted(4, 300'000, kCounty);
  Stopwatch watch;
  const PointsByTile sorted =
      *SortByTile(points, 0, Pose(), VoxelGrid(0.1), TileLayout(20, 0.1), kNoLimit, kToTheEnd);
  EXPECT_LT(watch.Ms(), 5000);
  EXPECT_GT(sorted.tiles.size(), 100'000u);
}

TEST(ScatteredPoints, OneSubmapLiesOnAnEighthOfTheTilesAtMost) {
  std::mt19937 rng(5);
  auto points = RandomPoints(&rng, 20'000, kCounty);
  const auto room = RandomPoints(&rng, 3000, kHall);
  points.insert(points.end(), room.begin(), room.end());
  Composer composer({.max_tiles = 160});
  const auto map = Compose(&composer, 1, {MakeSubmap("mallory", 3, points)});
  EXPECT_LE(TilesIn(map), 20u);
  EXPECT_LE(composer.last_tiles_remade(), 20);
  EXPECT_GT(map->point_count(0), 2500u) << "the room is not noise";
  EXPECT_GT(composer.left_out().points, 19'000u);
  EXPECT_EQ(composer.left_out().most, (SubmapId{SessionId("mallory-1"), 3}));
}

// Strewn over many submaps each of which is within its limit.
TEST(ScatteredPoints, ManySubmapsDoNotTakeTheOthersTiles) {
  std::mt19937 rng(6);
  std::vector<LaidSubmap> submaps{MakeSubmap("alice", 0, RandomPoints(&rng, 3000, kHall))};
  Composer alone({.max_tiles = 400});
  const auto expected = ReadAll(*Compose(&alone, 1, submaps));
  for (uint32_t i = 0; i < 40; ++i) {
    submaps.push_back(MakeSubmap("mallory", i, RandomPoints(&rng, 45, kCounty)));
  }
  submaps.push_back(MakeSubmap("mallory", 40, RandomPoints(&rng, 50, kCounty)));
  Composer composer({.max_tiles = 400});
  const auto map = Compose(&composer, 1, submaps);
  EXPECT_LE(TilesIn(map), 400u);
  EXPECT_GT(composer.left_out().points, 1000u);
  EXPECT_EQ(composer.left_out().most, (SubmapId{SessionId("mallory-1"), 40}));
  Region of_alice;
  of_alice.robot = 0;
  ExpectSamePoints(ReadAll(*map, of_alice), expected);

  submaps.resize(2);  // Then there is room for all.
  const auto after = Compose(&composer, 2, submaps);
  EXPECT_EQ(composer.left_out().points, 0u);
  EXPECT_EQ(after->point_count(0), expected.size() + 45);
}

// The points that are left out do not depend on earlier compositions.
TEST(ScatteredPoints, IncrementalEqualsFromScratch) {
  const ComposerOptions options{.tile_m = 8, .voxel_m = 0.3, .min_move_m = 0, .max_tiles = 32};
  std::mt19937 rng(7);
  std::vector<LaidSubmap> submaps, in_map;
  const Box cell = MakeBox({-3.5, -2.5, 0}, {3.5, 2.5, 2});
  for (uint32_t i = 0; i < 26; ++i) {
    submaps.push_back(MakeSubmap(i % 2 ? "alice" : "bob", i, RandomPoints(&rng, 100, cell)));
  }
  Composer composer(options);
  std::set<bool> was_there_room;
  for (int step = 0; step < 200; ++step) {
    Stir(submaps, {60, 3, 3}, &rng, &in_map);
    const auto map = Compose(&composer, step, in_map);
    Composer fresh(options);
    const auto expected = Compose(&fresh, step, in_map);
    EXPECT_LE(TilesIn(map, 0) + TilesIn(map, 1), 32u);
    ASSERT_EQ(composer.left_out().points, fresh.left_out().points);
    ASSERT_EQ(composer.left_out().most, fresh.left_out().most);
    was_there_room.insert(fresh.left_out().points == 0);
    for (uint32_t component = 0; component < 2; ++component) {
      Region region;
      region.component = component;
      ExpectSamePoints(ReadAll(*map, region), ReadAll(*expected, region));
    }
  }
  EXPECT_EQ(was_there_room.size(), 2u) << "both were tried";
}

// An upload need not say where its sensor stood, so all of a route may be one submap.
TEST(ScatteredPoints, ARouteOfTenKilometresIsNone) {
  std::mt19937 rng(8);
  std::vector<SubmapPoint> route;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d at(20. * i, 300 * std::sin(i / 40.), 0);
    const auto seen = RandomPoints(&rng, 60,
                                   MakeBox(at + Eigen::Vector3d(-60, -60, -1),  //
                                           at + Eigen::Vector3d(60, 60, 5)));
    route.insert(route.end(), seen.begin(), seen.end());
  }
  Composer composer({});
  const auto map = Compose(&composer, 1, {MakeSubmap("alice", 0, route)});
  EXPECT_EQ(composer.left_out().points, 0u);
  EXPECT_GT(TilesIn(map), 3000u);
  EXPECT_GT(map->point_count(0), route.size() * 99 / 100);
}

// Every stop comes before the first submap is done, and leaves nothing of it.
TEST(ScatteredPoints, CompositionEndsInTheMiddleOfASubmap) {
  std::mt19937 rng(9);
  std::vector<LaidSubmap> submaps{MakeSubmap("mallory", 0, RandomPoints(&rng, 100'000, kCounty)),
                                  MakeSubmap("mallory", 1, RandomPoints(&rng, 100, kCounty))};
  Composer composer({}), fresh({});
  for (size_t asked = 1; asked <= 3; ++asked) {  // Thinning, grouping, sorting.
    std::vector<double> told;
    const auto stopped = composer.Compose(1, Placed(submaps), ReaderOf(submaps), [&](double share) {
      told.push_back(share);
      return told.size() < asked;
    });
    EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled);
    EXPECT_EQ(told, std::vector<double>(asked, 0));
  }
  ExpectSamePoints(ReadAll(*Compose(&composer, 2, submaps)), ReadAll(*Compose(&fresh, 2, submaps)));

  submaps[0].T_map_submap = Pose(Eigen::Vector3d(7, 7, 0));  // Now it is sorted only.
  const auto stopped = composer.Compose(3, Placed(submaps), ReaderOf(submaps), [](double share) {
    EXPECT_EQ(share, 0);
    return false;
  });
  EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled);
  ExpectSamePoints(ReadAll(*Compose(&composer, 4, submaps)), ReadAll(*Compose(&fresh, 4, submaps)));
}

}  // namespace
}  // namespace isthmus::composition
