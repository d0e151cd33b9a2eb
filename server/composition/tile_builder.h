// Makes tiles from the thinned submaps that lie on them.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "core/ids.h"
#include "server/composition/thinned_submap.h"
#include "server/composition/tile.h"

namespace isthmus::composition {

// Not thread safe. The order in which submaps are added decides the order of points and the last
// digit of their means: add them in order of id for the same tiles every time.
class TileBuilder {
 public:
  // Points of other tiles are passed over.
  TileBuilder(const std::vector<TileKey>& wanted, const VoxelGrid& grid, const TileLayout& layout);

  void Add(const ThinnedSubmap& submap, uint32_t robot, uint32_t frame, const Pose& T_map_submap);

  // Every wanted tile, in the order given; null for one that got no point. `robots` maps robot
  // numbers to ids. Call once.
  std::vector<TilePtr> Finish(const std::vector<RobotId>& robots, VoxelThinner* thinner);

 private:
  struct Entry {
    uint64_t voxel;
    WeightedPoint point;
  };
  struct RobotPoints {
    uint32_t robot;
    std::vector<Entry> entries;
  };
  using Bucket = std::vector<RobotPoints>;  // Few robots: searched from the back.

  static std::vector<Entry>* EntriesOf(Bucket* bucket, uint32_t robot);
  static TilePtr MakeTile(Bucket* bucket, const std::vector<RobotId>& robots,
                          VoxelThinner* thinner);

  const VoxelGrid grid_;
  const TileLayout layout_;
  absl::flat_hash_map<TileKey, size_t> bucket_of_tile_;
  std::vector<Bucket> buckets_;  // One per wanted tile.
};

}  // namespace isthmus::composition
