#include "server/matching/surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "server/matching/kd_tree.h"
#include "server/matching/voxel_filter.h"

namespace isthmus::matching {
namespace {

constexpr int kNeighbors = 16;
constexpr size_t kMinNeighbors = 6;
// Neighbourhoods reach this many voxels at the most.
constexpr float kNeighborhoodVoxels = 6.0f;
// Below this middle over largest eigenvalue the neighbours lie on a line.
constexpr float kMinPlanarity = 0.03f;

// False when the neighbours do not span a surface.
bool EstimateNormal(const std::vector<Eigen::Vector3f>& points,
                    const std::vector<KdTree::Neighbor>& neighbors,
                    const Eigen::Vector3f& to_sensor, SurfacePoint* point) {
  if (neighbors.size() < kMinNeighbors) return false;
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

// Surfaces are areas: their points grow fewer with the square of the voxel.
std::vector<ViewedPoint> FilterToAtMost(const SessionMap& map, size_t max_points, double* voxel_m) {
  std::vector<ViewedPoint> thinned = FilterVoxels(map, *voxel_m);
  if (max_points == 0 || thinned.size() <= max_points) return thinned;
  *voxel_m *= std::sqrt(static_cast<double>(thinned.size()) / static_cast<double>(max_points));
  return FilterVoxels(map, *voxel_m);
}

}  // namespace

std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m) {
  return SampleSurface(map, 0, &voxel_m);
}

std::vector<SurfacePoint> SampleSurface(const SessionMap& map, size_t max_points, double* voxel_m) {
  const std::vector<ViewedPoint> thinned = FilterToAtMost(map, max_points, voxel_m);
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(thinned.size());
  for (const ViewedPoint& point : thinned) positions.push_back(point.position);
  const KdTree tree(positions);
  const float reach = kNeighborhoodVoxels * static_cast<float>(*voxel_m);
  std::vector<SurfacePoint> surface;
  surface.reserve(positions.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (size_t i = 0; i < positions.size(); ++i) {
    SurfacePoint point{positions[i], Eigen::Vector3f::Zero(), 1.0f};
    tree.KNearest(positions[i], kNeighbors, reach, &neighbors);
    if (EstimateNormal(positions, neighbors, thinned[i].to_sensor, &point)) {
      surface.push_back(point);
    }
  }
  return surface;
}

}  // namespace isthmus::matching
