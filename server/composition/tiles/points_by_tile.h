// A submap's points sorted by the tile they lie on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/pose.h"
#include "server/composition/keep_on.h"
#include "server/composition/tiles/tile_layout.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Points of a submap that stand together, on one tile: [begin, end) of its thinned points.
struct PointRun {
  uint32_t begin = 0, end = 0;
};

// The points of a submap on each tile, at the pose that this was made for. Kept with a submap, so
// that its neighbours' tiles can be remade without looking at its other points.
struct PointsByTile {
  std::vector<TileKey> tiles;         // In order; none without points.
  std::vector<uint32_t> point_count;  // Points on each tile.
  std::vector<uint32_t> begin;        // First of each tile's runs, and the end of the last.
  std::vector<PointRun> runs;         // Ascending within a tile.
  uint64_t left_out = 0;              // Points on tiles beyond the limit.

  // The runs of the i-th tile.
  std::span<const PointRun> Of(size_t i) const {
    return std::span(runs).subspan(begin[i], begin[i + 1] - begin[i]);
  }
};

// Leaves out points that the pose takes off the grid, and tiles beyond the limit, see TileLimit.
// Takes time in proportion to the points, however many tiles they are strewn over. Nothing when
// told to end.
std::optional<PointsByTile> SortByTile(const std::vector<WeightedPoint>& points, uint32_t frame,
                                       const Pose& T_map_submap, const VoxelGrid& grid,
                                       const TileLayout& layout, size_t max_tiles,
                                       const KeepOn& keep_on);

}  // namespace isthmus::composition
