// The voxels that both sides of a comparison have seen, and those that one side alone has.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>
#include <vector>

#include "core/geometry/voxel_hash.h"
#include "core/map/region_extent.h"
#include "server/composition/changes/changed_points.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Not thread safe.
class SeenVoxels {
 public:
  // Points outside of `extent` count as seen, but none of them is OfOneSide.
  explicit SeenVoxels(const RegionExtent& extent);

  // False when told to end.
  bool Add(uint32_t index, const ComparedSubmap& compared, const Submap& submap,
           const KeepOn& keep_on);
  size_t size() const { return seen_.size(); }

  // The points of either side that lie in the region, and not within kStillThereVoxels of what the
  // other has seen; without floors and ceilings. Their looks are those of Add. Empty when told to
  // end.
  std::vector<ChangedPoint> OfOneSide(const KeepOn& keep_on) const;

 private:
  struct Seen {
    Voxel voxel;
    bool after = false;
    uint32_t submap = 0, hits = 0;
    uint64_t last_keyframe = 0;  // The last keyframe counted in `hits`.
    int64_t first_ns = 0, last_ns = 0;
    Eigen::Vector3f along;
  };
  struct Heights {
    float lowest, highest;
  };
  struct Times {
    int64_t first_ns, last_ns;
  };

  bool IsFloorOrCeiling(const Seen& seen) const;
  // The direction across the surface that the voxel is part of, by those around it, away from where
  // it was seen first; that of the look where there is no surface.
  Eigen::Vector3f Inward(const Seen& seen) const;
  // The vector to the nearest voxel of the other side, in voxels; zero if there is none near.
  Eigen::Vector3i ToOther(const Seen& seen) const;

  const RegionExtent extent_;
  const VoxelGrid grid_, columns_, parts_;
  // Indices into `seen_`, by side and voxel.
  absl::flat_hash_map<uint64_t, uint32_t, VoxelHash> numbers_;
  std::vector<Seen> seen_;
  absl::flat_hash_map<uint64_t, Heights, VoxelHash> heights_;  // By side and column.
  std::vector<Eigen::Vector3i> around_;                        // The nearest first.
};

// A voxel of one of the sides.
inline uint64_t SideKey(const Voxel& v, bool after) {
  return PackVoxel(v) | (after ? uint64_t{1} << 63 : 0);
}
inline Eigen::Vector3f MiddleOf(const Voxel& v, double edge_m) {
  return (Eigen::Vector3d(v.x + 0.5, v.y + 0.5, v.z + 0.5) * edge_m).cast<float>();
}

}  // namespace isthmus::composition
