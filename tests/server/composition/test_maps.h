// Submaps of random points, and what a map of them must hold.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/map/composed_map.h"
#include "server/composition/composer.h"

namespace isthmus::composition {

// A submap with its points, where it lies.
struct LaidSubmap {
  std::shared_ptr<const Submap> submap;
  uint32_t component = 0;
  Pose T_map_submap;
};

inline std::vector<PlacedSubmap> Placed(const std::vector<LaidSubmap>& submaps) {
  std::vector<PlacedSubmap> placed;
  for (const LaidSubmap& laid : submaps) {
    auto info = laid.submap ? std::make_shared<SubmapInfo>(Summarize(*laid.submap)) : nullptr;
    placed.push_back({std::move(info), laid.component, laid.T_map_submap});
  }
  return placed;
}

// Null for any other. Counts what it is asked for, if told where.
inline SubmapReader ReaderOf(const std::vector<LaidSubmap>& submaps, int* reads = nullptr) {
  std::map<SubmapId, std::shared_ptr<const Submap>> by_id;
  for (const LaidSubmap& laid : submaps) {
    if (laid.submap) by_id[laid.submap->id] = laid.submap;
  }
  return [by_id = std::move(by_id), reads](const SubmapId& id) {
    if (reads != nullptr) ++*reads;
    const auto it = by_id.find(id);
    return it == by_id.end() ? nullptr : it->second;
  };
}

// Driven in the index-th minute of 2001-09-09, from 01:46:40 on.
inline LaidSubmap MakeSubmap(const std::string& robot, uint32_t index,
                             std::vector<SubmapPoint> points, const Pose& T_map_submap = Pose(),
                             uint32_t component = 0) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId(robot + "-1"), index};
  submap->robot = RobotId(robot);
  submap->last_stamp_ns = (1'000'000'000 + 60 * int64_t{index}) * 1'000'000'000;
  submap->keyframes.resize(1);
  submap->points = std::move(points);
  return {submap, component, T_map_submap};
}

inline std::shared_ptr<const ComposedMap> Compose(Composer* composer, int64_t revision,
                                                  const std::vector<LaidSubmap>& submaps) {
  auto map = composer->Compose(revision, Placed(submaps), ReaderOf(submaps));
  EXPECT_TRUE(map.ok()) << map.status();
  return map.ok() ? *map : nullptr;
}

inline SubmapPoint At(double x, double y, double z, double intensity = 0) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z),
          static_cast<float>(intensity), 0};
}

// Uniform in the box.
inline std::vector<SubmapPoint> RandomPoints(std::mt19937* rng, int count, const Box& box) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<SubmapPoint> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d share(unit(*rng), unit(*rng), unit(*rng));
    const Eigen::Vector3d p = box.min + share.cwiseProduct(box.max - box.min);
    points.push_back(At(p.x(), p.y(), p.z(), unit(*rng)));
  }
  return points;
}

// The changes that `Stir` makes to a map: lays submaps within so many metres, one in so many
// elsewhere.
struct Stirring {
  unsigned reach_m = 9, erase_one_in = 3, other_component_one_in = 4;
};

// Puts one of the submaps, by chance, into the map, or moves it there, or takes it away.
inline void Stir(const std::vector<LaidSubmap>& submaps, const Stirring& how, std::mt19937* rng,
                 std::vector<LaidSubmap>* in_map) {
  const LaidSubmap& picked = submaps[(*rng)() % submaps.size()];
  const auto it = std::find_if(in_map->begin(), in_map->end(), [&](const LaidSubmap& laid) {
    return laid.submap->id == picked.submap->id;
  });
  if (it == in_map->end()) {
    in_map->push_back(picked);
  } else if ((*rng)() % how.erase_one_in == 0) {
    in_map->erase(it);
  } else {
    it->T_map_submap =
        Pose::FromXyzRpy((*rng)() % how.reach_m, (*rng)() % how.reach_m, 0, 0, 0, (*rng)() % 6);
    it->component = (*rng)() % how.other_component_one_in == 0;
  }
}

inline Box MakeBox(const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  Box box;
  box.Extend(min);
  box.Extend(max);
  return box;
}

inline std::vector<MapPoint> ReadAll(const ComposedMap& map, const Region& region = {},
                                     size_t chunk = 1000) {
  std::vector<MapPoint> all;
  const absl::Status status = map.Read(region, chunk, [&](const std::vector<MapPoint>& points) {
    all.insert(all.end(), points.begin(), points.end());
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  return all;
}

// All that is said of a point.
using PointTuple = std::tuple<float, float, float, float, uint32_t, uint32_t>;
inline std::vector<PointTuple> InOrder(const std::vector<MapPoint>& points) {
  std::vector<PointTuple> all;
  all.reserve(points.size());
  for (const MapPoint& p : points) all.emplace_back(p.x, p.y, p.z, p.intensity, p.robot, p.stamp);
  return all;
}

// In an order of their own, to compare as sets.
inline std::vector<PointTuple> Sorted(const std::vector<MapPoint>& points) {
  std::vector<PointTuple> sorted = InOrder(points);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

inline std::vector<MapPoint> ReadTile(const ComposedMap& map, const TileId& id) {
  const absl::StatusOr<std::vector<MapPoint>> points = map.ReadTile(id);
  EXPECT_TRUE(points.ok()) << points.status();
  return points.value_or(std::vector<MapPoint>());
}

// Tile by tile and level by level, point for point; in all but how old they are.
inline void ExpectSameTiles(const ComposedMap& map, const ComposedMap& expected) {
  ASSERT_EQ(map.component_count(), expected.component_count());
  for (uint32_t component = 0; component < expected.component_count(); ++component) {
    ASSERT_EQ(map.tile_levels(component), expected.tile_levels(component));
    for (uint32_t level = 0; level < expected.tile_levels(component); ++level) {
      const auto tiles = map.Tiles(component, level);
      const auto expected_tiles = expected.Tiles(component, level);
      ASSERT_EQ(tiles.size(), expected_tiles.size());
      for (size_t i = 0; i < tiles.size(); ++i) {
        const TileInfo &tile = tiles[i], &other = expected_tiles[i];
        ASSERT_EQ(tile.id, other.id);
        ASSERT_EQ(tile.version, other.version);
        ASSERT_EQ(tile.points, other.points);
        ASSERT_EQ(tile.bounds.min, other.bounds.min);
        ASSERT_EQ(tile.bounds.max, other.bounds.max);
        ASSERT_EQ(InOrder(ReadTile(map, tile.id)), InOrder(ReadTile(expected, tile.id)));
      }
    }
  }
}

}  // namespace isthmus::composition
