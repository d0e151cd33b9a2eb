// A map's tiles one by one: their identity, their levels, and how they follow changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "server/composition/composer.h"
#include "server/composition/tiles/tiled_map.h"
#include "tests/server/composition/test_maps.h"
#include "tests/server/composition/tiles/failing_map_file.h"

namespace isthmus::composition {
namespace {

using ::testing::IsEmpty;
using Place = std::tuple<int, int, int>;

constexpr double kVoxelM = 0.25, kTileM = 7.5;

ComposerOptions Options() { return {.tile_m = kTileM, .voxel_m = kVoxelM, .min_move_m = 0}; }

Place PlaceOf(float x, float y, float z, uint32_t level) {
  const double edge = kVoxelM * (1 << level);
  const auto index = [&](float at) { return static_cast<int>(std::floor(at / edge)); };
  return {index(x), index(y), index(z)};
}

// Robots that walked around a square, on both sides of the origin.
std::vector<LaidSubmap> Square(unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<LaidSubmap> submaps;
  for (const char* robot : {"bob", "alice", "carol"}) {
    for (uint32_t index = 0; index < 4; ++index) {
      const uint32_t column = index % 2, row = index / 2;
      const Pose T_map_submap =
          Pose::FromXyzRpy(20. * column - 10, 20. * row - 10, rng() % 3, 0.02, -0.01, rng() % 6);
      submaps.push_back(MakeSubmap(robot, index,
                                   RandomPoints(&rng, 3000, MakeBox({-15, -15, -1}, {15, 15, 2})),
                                   T_map_submap));
    }
  }
  return submaps;
}

std::shared_ptr<const ComposedMap> ComposeAnew(const std::vector<LaidSubmap>& submaps) {
  Composer composer(Options());
  return Compose(&composer, 1, submaps);
}

uint64_t OnlyVersion(const std::vector<LaidSubmap>& submaps) {
  const auto tiles = ComposeAnew(submaps)->Tiles(0, 0);
  EXPECT_EQ(tiles.size(), 1u);
  return tiles.empty() ? 0 : tiles[0].version;
}

class MapTiles : public ::testing::Test {
 protected:
  const std::vector<LaidSubmap> submaps_ = Square(1);
  const std::shared_ptr<const ComposedMap> map_ = ComposeAnew(submaps_);
  const std::vector<MapPoint> all_ = ReadAll(*map_);
};

TEST_F(MapTiles, EachIsItsSquareOfTheMap) {
  EXPECT_EQ(map_->tile_m(), kTileM);
  EXPECT_EQ(map_->voxel_m(), kVoxelM);
  std::vector<MapPoint> from_tiles;
  for (const TileInfo& tile : map_->Tiles(0, 0)) {
    const auto points = ReadTile(*map_, tile.id);
    EXPECT_EQ(points.size(), tile.points);
    for (const MapPoint& p : points) {
      EXPECT_EQ(std::floor(p.x / kTileM), tile.id.x);
      EXPECT_EQ(std::floor(p.y / kTileM), tile.id.y);
      EXPECT_TRUE(tile.bounds.Contains({p.x, p.y, p.z}));
    }
    from_tiles.insert(from_tiles.end(), points.begin(), points.end());
    const auto found = map_->FindTile(tile.id);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->version, tile.version);
  }
  EXPECT_EQ(Sorted(from_tiles), Sorted(all_));
}

TEST_F(MapTiles, APrefixOfAPartIsALevelOfDetail) {
  for (const TilePtr& tile : dynamic_cast<const TiledMap&>(*map_).tiles(0)) {
    const TilePoints whole = tile->Points().value();
    for (uint32_t level = 0; level < kDetailLevels; ++level) {
      const TilePoints some = tile->Points(level).value();
      for (size_t part = 0; part < tile->parts().size(); ++part) {
        std::set<Place> there, in_prefix;
        for (uint32_t i = whole.ranges[part].first; i < whole.ranges[part].second; ++i) {
          const TilePoint& p = (*whole.points)[i];
          there.insert(PlaceOf(p.x, p.y, p.z, level));
        }
        for (uint32_t i = some.ranges[part].first; i < some.ranges[part].second; ++i) {
          const TilePoint& p = (*some.points)[i];
          EXPECT_TRUE(in_prefix.insert(PlaceOf(p.x, p.y, p.z, level)).second);
        }
        ASSERT_EQ(in_prefix, there);
      }
    }
  }
}

TEST_F(MapTiles, HigherLevelsHaveOnePointPerVoxel) {
  ASSERT_GE(map_->tile_levels(0), 3u);
  EXPECT_LE(map_->Tiles(0, map_->tile_levels(0) - 1).size(), 4u);
  const auto whole = Sorted(all_);
  for (uint32_t level = 1; level < map_->tile_levels(0); ++level) {
    std::set<Place> expected, got;
    for (const MapPoint& p : all_) expected.insert(PlaceOf(p.x, p.y, p.z, level));
    size_t points = 0;
    for (const TileInfo& tile : map_->Tiles(0, level)) {
      const auto read = ReadTile(*map_, tile.id);
      EXPECT_LE(read.size(), tile.points);
      EXPECT_EQ(Sorted(read), Sorted(ReadTile(*map_, tile.id))) << "as made and as kept";
      points += read.size();
      for (const MapPoint& p : read) {
        EXPECT_EQ(std::floor(p.x / (kTileM * (1 << level))), tile.id.x);
        EXPECT_EQ(std::floor(p.y / (kTileM * (1 << level))), tile.id.y);
        EXPECT_TRUE(tile.bounds.Contains({p.x, p.y, p.z}));
        got.insert(PlaceOf(p.x, p.y, p.z, level));
      }
      for (const auto& p : Sorted(read)) {
        EXPECT_TRUE(std::binary_search(whole.begin(), whole.end(), p)) << "was in the map";
      }
    }
    EXPECT_EQ(got, expected);
    EXPECT_EQ(points, expected.size());
  }
}

TEST_F(MapTiles, WhatDoesNotExistIsNotFound) {
  EXPECT_EQ(map_->tile_levels(1), 0u);
  EXPECT_THAT(map_->Tiles(1, 0), IsEmpty());
  EXPECT_THAT(map_->Tiles(0, 60), IsEmpty());
  const int32_t far = std::numeric_limits<int32_t>::max();
  for (const TileId& id : {TileId{1, 0, 0, 0}, TileId{0, 60, 0, 0}, TileId{0, 0, far, far},
                           TileId{0, 1, -far - 1, -far - 1}, TileId{0, 0, 0, 50}}) {
    EXPECT_EQ(map_->FindTile(id).status().code(), absl::StatusCode::kNotFound);
    EXPECT_EQ(map_->ReadTile(id).status().code(), absl::StatusCode::kNotFound);
  }
  EXPECT_EQ(ComposeAnew({})->tile_levels(0), 0u);
}

TEST_F(MapTiles, APointIsAsNewAsTheNewestSubmapThatSawIt) {
  const auto map = ComposeAnew({MakeSubmap("alice", 7, {At(1, 1, 1), At(3, 1, 1)}),
                                MakeSubmap("alice", 9, {At(3.01, 1, 1)}),
                                MakeSubmap("alice", 2, {At(1.01, 1, 1), At(3.02, 1, 1)})});
  const auto points = ReadAll(*map);
  ASSERT_EQ(points.size(), 2u);
  for (const MapPoint& p : points) {
    EXPECT_EQ(p.stamp, 1'000'000'000u + 60 * (p.x < 2 ? 7 : 9));
  }
}

TEST_F(MapTiles, AreTheSameInWhateverOrderSubmapsCome) {
  std::vector<LaidSubmap> shuffled = submaps_;
  std::mt19937 rng(3);
  for (int round = 0; round < 3; ++round) {
    std::shuffle(shuffled.begin(), shuffled.end(), rng);  // Robots get other numbers, too.
    ExpectSameTiles(*ComposeAnew(shuffled), *map_);
  }
}

// Each of what a reader sees.
TEST(TileVersion, TellsApartWhatDiffers) {
  const auto of = [](const char* robot, uint32_t index, std::vector<SubmapPoint> points) {
    return OnlyVersion({MakeSubmap(robot, index, std::move(points))});
  };
  const std::set<uint64_t> versions{of("alice", 0, {At(1, 1, 1, 5)}),
                                    of("bob", 0, {At(1, 1, 1, 5)}),
                                    of("alice", 1, {At(1, 1, 1, 5)}),
                                    of("alice", 0, {At(1, 1, 1.001, 5)}),
                                    of("alice", 0, {At(1, 1, 1, 6)}),
                                    of("alice", 0, {At(1, 1, 1, 5), At(2, 1, 1, 5)}),
                                    of("alice", 0, {At(-1, 1, 1, 5)}),
                                    OnlyVersion({MakeSubmap("alice", 0, {At(1, 1, 1, 5)}),
                                                 MakeSubmap("bob", 0, {At(1, 1, 1, 5)})})};
  EXPECT_EQ(versions.size(), 8u);
}

TEST(TileVersion, ComesBackWithAnUndoAndARevisionTellsSinceWhen) {
  std::vector<LaidSubmap> submaps = Square(4);
  Composer composer(Options());
  const auto first = Compose(&composer, 10, submaps);
  submaps[2].T_map_submap = Pose::FromXyzRpy(3, 14, 0, 0, 0, 1);
  const auto moved = Compose(&composer, 11, submaps);
  submaps[2].T_map_submap = Square(4)[2].T_map_submap;
  const auto undone = Compose(&composer, 12, submaps);
  ExpectSameTiles(*undone, *first);
  for (uint32_t level = 0; level < first->tile_levels(0); ++level) {
    int changed = 0;
    for (const TileInfo& tile : first->Tiles(0, level)) {
      EXPECT_EQ(tile.revision, 10);
      const auto between = moved->FindTile(tile.id), after = undone->FindTile(tile.id);
      const bool same = between.ok() && between->version == tile.version;
      changed += !same;
      ASSERT_TRUE(after.ok()) << after.status();
      EXPECT_EQ(after->revision, same ? 10 : 12);
      if (!between.ok()) continue;
      EXPECT_EQ(between->revision, same ? 10 : 11);
    }
    EXPECT_GT(changed, 0);
  }
  EXPECT_LT(undone->Tiles(0, 0)[0].revision, 12) << "not on that submap's way";
}

// Tiles that stay under a tile of a higher level do not hide that one left.
TEST(TileVersion, OfAHigherLevelChangesWhenATileGoes) {
  std::vector<LaidSubmap> submaps;
  for (uint32_t i = 0; i < 6; ++i)
    submaps.push_back(MakeSubmap("alice", i, {At(1 + 7.5 * i, 1, 0)}));
  Composer composer(Options());
  const auto before = Compose(&composer, 1, submaps);
  submaps.erase(submaps.begin() + 1);
  const auto after = Compose(&composer, 2, submaps);
  const TileId first{0, 1, 0, 0}, second{0, 1, 1, 0};
  EXPECT_NE(before->FindTile(first)->version, after->FindTile(first)->version);
  EXPECT_EQ(after->FindTile(first)->revision, 2);
  EXPECT_EQ(before->FindTile(second)->version, after->FindTile(second)->version);
  EXPECT_EQ(after->FindTile(second)->revision, 1);
}

TEST(SpilledTiles, OfALevelReadTheirPrefixesAlone) {
  ComposerOptions options = Options();
  options.cache_bytes = 0;
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(options, file);
  const auto map = Compose(&composer, 1, Square(5));
  for (uint32_t level = 1; level < map->tile_levels(0); ++level) {
    for (const TileInfo& tile : map->Tiles(0, level)) {
      file->bytes_read = 0;
      ReadTile(*map, tile.id);
      EXPECT_EQ(file->bytes_read, tile.points * sizeof(TilePoint));
      ReadTile(*map, tile.id);
      EXPECT_EQ(file->bytes_read, tile.points * sizeof(TilePoint)) << "kept once made";
    }
  }
  file->fail_reads = true;
  EXPECT_EQ(map->ReadTile(map->Tiles(0, 0)[0].id).status().code(), absl::StatusCode::kUnavailable);
}

TEST(SpilledTiles, ARegionReadsNoFinerThanItsResolution) {
  ComposerOptions options = Options();
  options.cache_bytes = 0;
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(options, file);
  const auto map = Compose(&composer, 1, Square(6));
  uint64_t expected = 0;
  for (const TilePtr& tile : dynamic_cast<const TiledMap&>(*map).tiles(0)) {
    for (const TilePart& part : tile->parts()) expected += part.EndOf(3) - part.begin;
  }
  file->bytes_read = 0;
  Region coarse;
  coarse.resolution_m = kVoxelM * 8;
  const auto points = ReadAll(*map, coarse);
  EXPECT_EQ(file->bytes_read, expected * sizeof(TilePoint));
  EXPECT_LT(expected, map->point_count(0) / 4);
  EXPECT_EQ(Sorted(points), Sorted(ReadAll(*ComposeAnew(Square(6)), coarse)));
}

TEST(MadeTilesTest, DropsWhatWasAskedForLongestAgo) {
  MadeTiles made(10 * sizeof(MapPoint));
  const auto points = std::make_shared<const std::vector<MapPoint>>(4);
  const MadeTileKey a{1, 0, 0, 7}, b{1, 0, 1, 8}, c{2, 0, 0, 7};
  made.Put(a, points);
  made.Put(b, points);
  EXPECT_NE(made.Find(a), nullptr);
  made.Put(c, points);
  EXPECT_NE(made.Find(a), nullptr);
  EXPECT_EQ(made.Find(b), nullptr);
  EXPECT_NE(made.Find(c), nullptr);
  EXPECT_EQ(made.bytes(), 8 * sizeof(MapPoint));
}

}  // namespace
}  // namespace isthmus::composition
