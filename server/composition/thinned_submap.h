// A submap thinned once, in its own frame, so that composing it again at another pose touches a
// fraction of its points.
#pragma once

#include <cstdint>
#include <vector>

#include "core/submap.h"
#include "server/composition/tile.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Tells a submap from another that got the same id after the first one's session was deleted.
struct SubmapFingerprint {
  int64_t first_stamp_ns = 0, last_stamp_ns = 0;
  uint64_t first_sequence = 0, last_sequence = 0;
  uint64_t points = 0, keyframes = 0;

  friend bool operator==(const SubmapFingerprint&, const SubmapFingerprint&) = default;
};

SubmapFingerprint FingerprintOf(const Submap& submap);

struct ThinnedSubmap {
  SubmapFingerprint fingerprint;
  std::vector<WeightedPoint> points;  // Submap frame.
  Box bounds;                         // Of those, submap frame.
};

// Leaves out points that are not finite or off the grid.
ThinnedSubmap Thin(const Submap& submap, const VoxelGrid& grid, VoxelThinner* thinner);

// The largest distance that any point of the box moves when its pose changes from one to the other.
// Exact: the displacement is affine in the point, so a corner has the largest.
double LargestMove(const Box& box, const Pose& T_map_source, const Pose& T_map_source_new);

// Calls visit(tile, voxel key, point in the map frame) for every point on the grid.
template <typename Visit>
void ForEachPlacedPoint(const ThinnedSubmap& submap, uint32_t frame, const Pose& T_map_submap,
                        const VoxelGrid& grid, const TileLayout& layout, const Visit& visit) {
  const Eigen::Matrix3f R = T_map_submap.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_map_submap.translation().cast<float>();
  for (const WeightedPoint& p : submap.points) {
    const Eigen::Vector3f q = R * Eigen::Vector3f(p.x, p.y, p.z) + t;
    const auto voxel = grid.Find(q.x(), q.y(), q.z());
    if (!voxel) continue;
    visit(layout.Find(frame, *voxel), PackVoxel(*voxel),
          WeightedPoint{q.x(), q.y(), q.z(), p.intensity, p.weight});
  }
}

}  // namespace isthmus::composition
