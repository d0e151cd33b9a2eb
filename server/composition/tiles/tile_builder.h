// Makes tiles from the thinned submaps that lie on them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/pose.h"
#include "server/composition/tiles/detail_order.h"
#include "server/composition/tiles/points_by_tile.h"
#include "server/composition/tiles/tile.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// A submap's part of one tile.
struct TileSource {
  const std::vector<WeightedPoint>* points = nullptr;  // Submap frame.
  std::span<const PointRun> runs;                      // Points that lie on the tile.
  Pose T_map_submap;
  uint32_t robot = 0;  // The composer's own number.
  uint32_t stamp = 0;  // As MapPoint's.
  bool gone = false;   // Points that are gone, see visibility/, instead of all others.
};

// One tile at a time, one source after the other, so that only one has to be in memory. The order
// of a robot's sources decides the last digit of points: give them in order of submap for the same
// tile every time. Not thread safe.
class TileBuilder {
 public:
  TileBuilder(const VoxelGrid& grid, VoxelThinner* thinner) : grid_(grid), thinner_(thinner) {}

  // A robot's sources stand together.
  void Add(const TileSource& source);
  // The points added since the last TakeContent; of the record, parts and bounds.
  TileContent TakeContent();
  // True if the last source had points of the other kind, which were left out.
  bool left_out() const { return left_out_; }

 private:
  void EndPart();
  void TakePoints();

  const VoxelGrid grid_;
  VoxelThinner* const thinner_;
  TileContent tile_;
  bool has_part_ = false;  // The thinner holds points of robot_.
  uint32_t robot_ = 0;
  bool left_out_ = false;
  // State of the part that ends.
  std::vector<TilePoint> points_;
  std::vector<Voxel> voxels_;
  DetailOrder order_;
};

}  // namespace isthmus::composition
