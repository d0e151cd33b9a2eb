#include "server/matching/surface.h"

#include <absl/container/flat_hash_map.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "server/matching/kd_tree.h"
#include "server/matching/voxel_key.h"

namespace isthmus::matching {
namespace {

constexpr float kMaxCoordinateM = 1e5f;
constexpr int kNeighbors = 16;
constexpr size_t kMinNeighbors = 6;
// Neighbourhoods reach this many voxels at the most.
constexpr float kNeighborhoodVoxels = 6.0f;
// Below this middle over largest eigenvalue the neighbours lie on a line.
constexpr float kMinPlanarity = 0.03f;

struct VoxelMean {
  Eigen::Vector3f anchor;  // First point; sums are relative to it to keep float precision.
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Vector3f to_sensor = Eigen::Vector3f::Zero();  // Sum of unit vectors.
  int count = 0;

  Eigen::Vector3f mean() const { return anchor + sum / static_cast<float>(count); }
};

class Thinner {
 public:
  Thinner(double voxel_m, size_t expected) : inverse_voxel_(static_cast<float>(1.0 / voxel_m)) {
    index_of_.reserve(expected);
  }

  void Add(const Submap& submap) {
    const Eigen::Matrix3f R = submap.T_odom_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = submap.T_odom_submap.translation().cast<float>();
    std::vector<Eigen::Vector3f> sensors;
    for (const Keyframe& keyframe : submap.keyframes) {
      sensors.push_back(
          (submap.T_odom_submap * keyframe.T_submap_sensor.translation()).cast<float>());
    }
    for (const SubmapPoint& point : submap.points) {
      if (point.keyframe >= sensors.size()) continue;
      const Eigen::Vector3f p = R * point.Position() + t;
      // Written so that NaN fails too.
      if (!(p.cwiseAbs().maxCoeff() < kMaxCoordinateM)) continue;
      Add(p, (sensors[point.keyframe] - p).normalized());
    }
  }

  const std::vector<VoxelMean>& voxels() const { return voxels_; }

 private:
  void Add(const Eigen::Vector3f& p, const Eigen::Vector3f& to_sensor) {
    const auto [entry, added] =
        index_of_.try_emplace(VoxelKey(p, inverse_voxel_), static_cast<int>(voxels_.size()));
    if (added) voxels_.push_back({p});
    VoxelMean& voxel = voxels_[entry->second];
    voxel.sum += p - voxel.anchor;
    voxel.to_sensor += to_sensor;
    ++voxel.count;
  }

  const float inverse_voxel_;
  absl::flat_hash_map<uint64_t, int> index_of_;
  std::vector<VoxelMean> voxels_;
};

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

}  // namespace

std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m) {
  size_t raw = 0;
  for (const auto& submap : map.submaps) raw += submap->points.size();
  Thinner thinner(voxel_m, raw / 8);
  for (const auto& submap : map.submaps) thinner.Add(*submap);

  std::vector<Eigen::Vector3f> positions;
  positions.reserve(thinner.voxels().size());
  for (const VoxelMean& voxel : thinner.voxels()) positions.push_back(voxel.mean());
  const KdTree tree(positions);
  const float reach = kNeighborhoodVoxels * static_cast<float>(voxel_m);
  std::vector<SurfacePoint> surface;
  surface.reserve(positions.size());
  std::vector<KdTree::Neighbor> neighbors;
  for (size_t i = 0; i < positions.size(); ++i) {
    SurfacePoint point{positions[i], Eigen::Vector3f::Zero(), 1.0f};
    tree.KNearest(positions[i], kNeighbors, reach, &neighbors);
    if (EstimateNormal(positions, neighbors, thinner.voxels()[i].to_sensor, &point)) {
      surface.push_back(point);
    }
  }
  return surface;
}

}  // namespace isthmus::matching
