#include "server/composition/thinned_submap.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <numeric>

#include "server/composition/limits.h"

namespace isthmus::composition {
namespace {

// Blocks in the order in which they are first met; order within a block stays. Nothing when told to
// end.
std::optional<std::vector<WeightedPoint>> GroupByBlock(const std::vector<WeightedPoint>& points,
                                                       const VoxelGrid& grid,
                                                       const KeepOn& keep_on) {
  absl::flat_hash_map<uint64_t, uint32_t> numbers;
  std::vector<uint32_t> block_of_point, next;
  block_of_point.reserve(points.size());
  for (const WeightedPoint& p : points) {
    if (EndsAt(block_of_point.size(), keep_on)) return std::nullopt;
    const Voxel voxel = grid.Find(p.x, p.y, p.z).value_or(Voxel());
    const uint64_t block =
        PackVoxel({voxel.x / kBlockVoxels, voxel.y / kBlockVoxels, voxel.z / kBlockVoxels});
    const auto [it, is_new] = numbers.try_emplace(block, static_cast<uint32_t>(next.size()));
    if (is_new) next.push_back(0);
    ++next[it->second];
    block_of_point.push_back(it->second);
  }
  std::exclusive_scan(next.begin(), next.end(), next.begin(), uint32_t{0});
  std::vector<WeightedPoint> grouped(points.size());
  for (size_t i = 0; i < points.size(); ++i) grouped[next[block_of_point[i]]++] = points[i];
  return grouped;
}

}  // namespace

SubmapFingerprint FingerprintOf(const SubmapInfo& submap) {
  return {submap.first_stamp_ns, submap.last_stamp_ns,  submap.first_sequence, submap.last_sequence,
          submap.point_count,    submap.keyframe_count, submap.content};
}

bool CoversTheSame(const Submap& submap, const SubmapFingerprint& meant) {
  const SubmapFingerprint its{submap.first_stamp_ns, submap.last_stamp_ns, submap.first_sequence,
                              submap.last_sequence,  submap.points.size(), submap.keyframes.size(),
                              meant.content};
  return its == meant;
}

std::optional<ThinnedSubmap> Thin(const Submap& submap, const VoxelGrid& grid,
                                  VoxelThinner* thinner, const KeepOn& keep_on) {
  std::vector<WeightedPoint> in_order_met;
  for (size_t i = 0; i < submap.points.size(); ++i) {
    if (EndsAt(i, keep_on)) {
      thinner->TakePoints(&in_order_met);  // The next cloud must not find them there.
      return std::nullopt;
    }
    const SubmapPoint& p = submap.points[i];
    if (const auto voxel = grid.Find(p.x, p.y, p.z)) {
      thinner->Add(PackVoxel(*voxel), {p.x, p.y, p.z, p.intensity});
    }
  }
  thinner->TakePoints(&in_order_met);
  auto grouped = GroupByBlock(in_order_met, grid, keep_on);
  if (!grouped) return std::nullopt;
  ThinnedSubmap thinned;
  thinned.points = *std::move(grouped);
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
