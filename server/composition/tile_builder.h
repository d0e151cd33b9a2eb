// Makes tiles from the thinned submaps that lie on them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/ids.h"
#include "core/pose.h"
#include "server/composition/thinned_submap.h"
#include "server/composition/tile.h"

namespace isthmus::composition {

// Points of a submap that stand together, on one tile: [begin, end) of ThinnedSubmap::points.
struct PointRun {
  uint32_t begin = 0, end = 0;
};

// Which of a submap's points lie on which tile, at the pose that it was made for. Kept with a
// submap, so that its neighbours' tiles can be remade without looking at its other points.
struct PointsByTile {
  std::vector<TileKey> tiles;   // In order; none without points.
  std::vector<uint32_t> begin;  // Of each tile's runs, and the end of the last.
  std::vector<PointRun> runs;   // Ascending within a tile.

  // Of the i-th tile.
  std::span<const PointRun> Of(size_t i) const {
    return std::span(runs).subspan(begin[i], begin[i + 1] - begin[i]);
  }
};

// Leaves out points that the pose takes off the grid.
PointsByTile SortByTile(const ThinnedSubmap& submap, uint32_t frame, const Pose& T_map_submap,
                        const VoxelGrid& grid, const TileLayout& layout);

// A submap's part of one tile.
struct TileSource {
  const ThinnedSubmap* submap = nullptr;
  Pose T_map_submap;
  uint32_t robot = 0;  // The composer's own number.
  std::span<const PointRun> runs;
};

// Null without sources. `robots` maps robot numbers to ids. The order of a robot's sources decides
// the order of points and the last digit of their means: give them in order of submap for the same
// tile every time.
TilePtr MakeTile(std::vector<TileSource> sources, const std::vector<RobotId>& robots,
                 const VoxelGrid& grid, VoxelThinner* thinner);

}  // namespace isthmus::composition
