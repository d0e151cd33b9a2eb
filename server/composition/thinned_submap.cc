#include "server/composition/thinned_submap.h"

#include <algorithm>

namespace isthmus::composition {

SubmapFingerprint FingerprintOf(const Submap& submap) {
  return {submap.first_stamp_ns, submap.last_stamp_ns, submap.first_sequence,
          submap.last_sequence,  submap.points.size(), submap.keyframes.size()};
}

ThinnedSubmap Thin(const Submap& submap, const VoxelGrid& grid, VoxelThinner* thinner) {
  for (const SubmapPoint& p : submap.points) {
    if (const auto voxel = grid.Find(p.x, p.y, p.z)) {
      thinner->Add(PackVoxel(*voxel), {p.x, p.y, p.z, p.intensity});
    }
  }
  ThinnedSubmap thinned;
  thinned.fingerprint = FingerprintOf(submap);
  thinner->Take(&thinned.points);
  for (const WeightedPoint& p : thinned.points) {
    thinned.bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
  }
  return thinned;
}

double LargestMove(const Box& box, const Pose& T_map_source, const Pose& T_map_source_new) {
  if (box.empty()) return 0;
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p(corner & 1 ? box.max.x() : box.min.x(),
                            corner & 2 ? box.max.y() : box.min.y(),
                            corner & 4 ? box.max.z() : box.min.z());
    largest = std::max(largest, (T_map_source_new * p - T_map_source * p).norm());
  }
  return largest;
}

}  // namespace isthmus::composition
