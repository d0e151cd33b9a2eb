#include "server/matching/prepared/distinctive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/prepared/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

uint64_t Voxel(const Eigen::Vector3f& p) { return VoxelKey(p, 1 / kRepeatedVoxelM); }

}  // namespace

DistinctiveMap::DistinctiveMap(const PreparedSubmaps& submaps, const Eigen::Vector3d& up,
                               std::vector<Pose> moves)
    : up_(up), moves_(std::move(moves)) {
  Add(submaps);
}

DistinctiveMap::DistinctiveMap(DistinctiveMap before, const PreparedSubmaps& submaps)
    : DistinctiveMap(std::move(before)) {
  Add(submaps);
}

void DistinctiveMap::Add(const PreparedSubmaps& submaps) {
  std::vector<Eigen::Vector3f> fresh;  // A point of each new voxel.
  for (; submaps_ < submaps.size(); ++submaps_) {
    const PreparedSubmap& submap = *submaps[submaps_];
    const Pose& T_odom_submap = submap.submap().T_odom_submap;
    const Eigen::Vector3f up = (T_odom_submap.rotation().inverse() * up_).cast<float>();
    const Eigen::Matrix3f R = T_odom_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_odom_submap.translation().cast<float>();
    for (const SurfacePoint& point : submap.surface()) {
      if (std::abs(point.normal.dot(up)) > kMaxUprightNormalZ) continue;
      const Eigen::Vector3f p = R * point.position + t;
      if (standing_.insert(Voxel(p)).second) fresh.push_back(p);
    }
  }
  for (const Eigen::Vector3f& p : fresh) {
    const bool repeated = std::any_of(moves_.begin(), moves_.end(), [&](const Pose& move) {
      return StandsNear((move * p.cast<double>()).cast<float>());
    });
    if (!repeated) distinctive_.insert(Voxel(p));
  }
}

bool DistinctiveMap::StandsNear(const Eigen::Vector3f& p) const {
  if (standing_.contains(Voxel(p))) return true;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f half = kRepeatedVoxelM / 2 * Eigen::Vector3f::Unit(axis);
    if (standing_.contains(Voxel(p + half)) || standing_.contains(Voxel(p - half))) return true;
  }
  return false;
}

bool DistinctiveMap::Has(const Eigen::Vector3f& p) const { return distinctive_.contains(Voxel(p)); }

}  // namespace isthmus::matching
