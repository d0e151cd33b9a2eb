#include "server/matching/registration/surface.h"

#include <absl/container/flat_hash_map.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "server/matching/registration/kd_tree.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/voxel_filter.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

// False when the neighbours do not span a surface.
bool EstimateNormal(const std::vector<Eigen::Vector3f>& points,
                    const std::vector<KdTree::Neighbor>& neighbors,
                    const Eigen::Vector3f& to_sensor, SurfacePoint* point) {
  if (neighbors.size() < kMinNormalNeighbors) return false;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const auto& n : neighbors) mean += points[n.index] - point->position;
  mean /= static_cast<float>(neighbors.size());
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const auto& n : neighbors) {
    const Eigen::Vector3f d = points[n.index] - point->position - mean;
    scatter.noalias() += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3f& values = solver.eigenvalues();
  if (!(values[1] > kMinPlanarity * values[2])) return false;
  point->normal = solver.eigenvectors().col(0).normalized();
  if (point->normal.dot(to_sensor) < 0) point->normal = -point->normal;
  point->roughness = std::clamp(values[0] / values[1], 0.0f, 1.0f);
  return point->normal.allFinite();
}

// Keeps at most `most`, spread evenly, in their order.
void KeepEvenly(size_t most, std::vector<ViewedPoint>* points) {
  if (points->size() <= most) return;
  for (size_t i = 0; i < most; ++i) (*points)[i] = (*points)[i * points->size() / most];
  points->resize(most);
}

std::vector<SurfacePoint> Sample(const std::vector<ViewedPoint>& thinned, double voxel_m,
                                 const std::stop_token& stop) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(thinned.size());
  for (const ViewedPoint& point : thinned) positions.push_back(point.position);
  const KdTree tree(positions);
  const float reach = kNormalReachVoxels * static_cast<float>(voxel_m);
  std::vector<SurfacePoint> surface;
  surface.reserve(positions.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (i % kPointsPerLook == 0 && stop.stop_requested()) return {};
    SurfacePoint point{positions[i], Eigen::Vector3f::Zero(), 1.0f};
    tree.KNearest(positions[i], kNormalNeighbors, reach, &neighbors);
    if (EstimateNormal(positions, neighbors, thinned[i].to_sensor, &point)) {
      surface.push_back(point);
    }
  }
  return surface;
}

std::vector<SurfacePoint> Join(const std::vector<SurfacePart>& parts, double voxel_m) {
  const auto inverse_voxel = static_cast<float>(1 / voxel_m);
  size_t expected = 0;
  for (const SurfacePart& part : parts) expected += part.points->size();
  absl::flat_hash_map<uint64_t, int> index_of;
  index_of.reserve(expected / 2);
  std::vector<SurfacePoint> joined;
  std::vector<int> counts;
  for (const SurfacePart& part : parts) {
    const Eigen::Matrix3f R = part.T_whole_part.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = part.T_whole_part.translation().cast<float>();
    for (const SurfacePoint& p : *part.points) {
      const SurfacePoint point{R * p.position + t, R * p.normal, p.roughness};
      const auto [entry, added] = index_of.try_emplace(VoxelKey(point.position, inverse_voxel),
                                                       static_cast<int>(joined.size()));
      if (added) {
        joined.push_back(point);
        counts.push_back(1);
        continue;
      }
      SurfacePoint& mean = joined[entry->second];
      if (mean.normal.dot(point.normal) < kMinJoinedCosine * mean.normal.norm()) continue;
      const float share = 1.0f / static_cast<float>(++counts[entry->second]);
      mean.position += share * (point.position - mean.position);
      mean.normal += share * (point.normal - mean.normal);
      mean.roughness += share * (point.roughness - mean.roughness);
    }
  }
  for (SurfacePoint& point : joined) point.normal.normalize();
  return joined;
}

}  // namespace

std::vector<SurfacePoint> SampleSurface(const Submap& submap, double voxel_m,
                                        const std::stop_token& stop) {
  std::vector<ViewedPoint> thinned = FilterVoxels(submap, voxel_m);
  KeepEvenly(kMaxSurfaceVoxels, &thinned);
  return Sample(thinned, voxel_m, stop);
}

std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m) {
  return Sample(FilterVoxels(map, voxel_m), voxel_m, {});
}

std::vector<SurfacePoint> JoinSurfaces(const std::vector<SurfacePart>& parts, size_t max_points,
                                       double* voxel_m) {
  std::vector<SurfacePoint> joined = Join(parts, *voxel_m);
  if (max_points == 0 || joined.size() <= max_points) return joined;
  // Surfaces are areas: their points grow fewer with the square of the voxel.
  *voxel_m *= std::sqrt(static_cast<double>(joined.size()) / static_cast<double>(max_points));
  return Join(parts, *voxel_m);
}

}  // namespace isthmus::matching
