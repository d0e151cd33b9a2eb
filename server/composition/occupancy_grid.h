// Occupancy along rays, kept in blocks of voxels: the working memory of an OctoMap being built.
//
// The evidence is OctoMap's own (Hornung et al., "OctoMap", Autonomous Robots 2013, section 3.2):
// log-odds, one hit or miss per voxel and scan, clamped (eq. 4). Within a scan a hit outweighs
// misses. What differs is only where it is kept: updating an octree costs a walk of 16 levels per
// voxel, a dense block costs one addition, and most rays cross the same voxels again and again.
#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "core/map/composed_map.h"

namespace isthmus::composition {

struct SensorEvidence {
  float hit = 0.85f;   // Log-odds added where a ray ended.
  float miss = -0.4f;  // Where one passed.
  float min = -2.0f;   // Clamped to these.
  float max = 3.5f;
};

// Not thread safe.
class OccupancyGrid {
 public:
  // Voxels have an edge of `resolution_m` and a corner at the origin. Only those with their middle
  // in box and sphere of `region` are kept.
  OccupancyGrid(double resolution_m, double max_range_m, uint64_t max_bytes,
                const SensorEvidence& evidence, const Region& region = {});

  // Inserts what one keyframe saw. Points of one voxel count once, with a ray to the voxel's
  // middle, as in OctoMap's discretised insertion; rays longer than the maximum range clear the way
  // up to it and hit nothing. Points that are not finite are left out. Everything within reach of
  // `origin` must be within 2^20 voxels of the origin of the grid. False, the scan inserted in
  // part, when the grid has outgrown `max_bytes`.
  bool InsertScan(const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& points);

  uint64_t known_voxels() const { return known_voxels_; }
  // Held by the grid, about.
  uint64_t bytes() const { return blocks_.size() * (sizeof(Block) + 64); }

  // Calls visit(x, y, z, log-odds) for every voxel that was seen; the indices count voxels from the
  // origin. In no particular order.
  template <typename Visit>
  void ForEachKnown(const Visit& visit) const;

 private:
  static constexpr int kBits = 3;  // Blocks of 8 x 8 x 8 voxels: 4 kB, a page.
  static constexpr int kEdge = 1 << kBits, kMask = kEdge - 1;
  using Index = Eigen::Matrix<int32_t, 3, 1>;

  struct Cell {
    float log_odds = std::numeric_limits<float>::quiet_NaN();  // Until first seen.
    uint32_t scan = 0;  // The last scan that changed it, so that each does so once.
  };
  using Block = std::array<Cell, kEdge * kEdge * kEdge>;

  Index IndexOf(const Eigen::Vector3d& p) const;
  Cell& CellAt(const Index& index);
  // False, and nothing changes, when the scan under way has changed the voxel already.
  bool Update(const Index& index, float evidence);
  bool IsWanted(const Index& index) const;
  void ClearRay(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

  const double resolution_m_;
  const double max_range_m_;
  const uint64_t max_bytes_;
  const SensorEvidence evidence_;
  const Region region_;
  const bool is_bounded_;
  absl::flat_hash_map<uint64_t, std::unique_ptr<Block>> blocks_;
  uint64_t last_key_ = ~uint64_t{0};  // Rays stay in a block for a while.
  Block* last_block_ = nullptr;
  uint32_t scan_ = 0;
  uint64_t known_voxels_ = 0;
  // Ends of the rays of the scan under way; kept to spare allocations.
  std::vector<Eigen::Vector3d> ray_ends_;
  absl::flat_hash_set<uint64_t> cut_ends_;  // Voxels in which rays end at the maximum range.
};

template <typename Visit>
void OccupancyGrid::ForEachKnown(const Visit& visit) const {
  for (const auto& [key, block] : blocks_) {
    const auto start = [key_ = key](int shift) {
      return (static_cast<int32_t>(key_ >> shift & 0x1fffff) - (1 << 20)) * kEdge;
    };
    for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
      const Cell& cell = (*block)[i];
      if (cell.scan == 0) continue;
      visit(start(42) + (i & kMask), start(21) + (i >> kBits & kMask), start(0) + (i >> 2 * kBits),
            cell.log_odds);
    }
  }
}

}  // namespace isthmus::composition
