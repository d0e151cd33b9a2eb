#include "server/matching/registration/voxel_filter.h"

#include <absl/container/flat_hash_map.h>

#include <cstdint>

#include "server/matching/registration/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

struct VoxelMean {
  Eigen::Vector3f anchor;  // First point; sums are relative to it to keep float precision.
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Vector3f to_sensor = Eigen::Vector3f::Zero();  // Sum of unit vectors.
  int count = 0;

  Eigen::Vector3f mean() const { return anchor + sum / static_cast<float>(count); }
};

class Thinner {
 public:
  explicit Thinner(double voxel_m) : inverse_voxel_(static_cast<float>(1.0 / voxel_m)) {}

  // Room for so many voxels more.
  void Reserve(size_t expected) { index_of_.reserve(index_of_.size() + expected); }

  void Add(const Submap& submap, const Pose& T_target_submap) {
    const Eigen::Matrix3f R = T_target_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_target_submap.translation().cast<float>();
    std::vector<Eigen::Vector3f> sensors;
    for (const Keyframe& keyframe : submap.keyframes) {
      sensors.push_back((T_target_submap * keyframe.T_submap_sensor.translation()).cast<float>());
    }
    for (const SubmapPoint& point : submap.points) {
      if (point.keyframe >= sensors.size()) continue;
      const Eigen::Vector3f p = R * point.Position() + t;
      // Written so that NaN fails too.
      if (!(p.cwiseAbs().maxCoeff() < kMaxSurfaceCoordinateM)) continue;
      Add(p, (sensors[point.keyframe] - p).normalized());
    }
  }

  std::vector<ViewedPoint> Take() const {
    std::vector<ViewedPoint> thinned;
    thinned.reserve(voxels_.size());
    for (const VoxelMean& voxel : voxels_) thinned.push_back({voxel.mean(), voxel.to_sensor});
    return thinned;
  }

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

}  // namespace

std::vector<ViewedPoint> FilterVoxels(const SessionMap& map, double voxel_m) {
  Thinner thinner(voxel_m);
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    const std::shared_ptr<const Submap> submap = map.Whole(k);
    thinner.Reserve(submap->points.size() / 8);
    thinner.Add(*submap, submap->T_odom_submap);
  }
  return thinner.Take();
}

std::vector<ViewedPoint> FilterVoxels(const Submap& submap, double voxel_m) {
  Thinner thinner(voxel_m);
  thinner.Reserve(submap.points.size() / 4);
  thinner.Add(submap, Pose());
  return thinner.Take();
}

}  // namespace isthmus::matching
