#include "server/matching/registration/vgicp.h"

#include <Eigen/LU>

#include "server/matching/registration/gicp.h"
#include "server/matching/registration/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

Eigen::Matrix3f DiscCovariance(const Eigen::Vector3f& normal, float across) {
  return Eigen::Matrix3f::Identity() - (1.0f - across) * normal * normal.transpose();
}

}  // namespace

GaussianVoxelMap::GaussianVoxelMap(const std::vector<SurfacePoint>& points, double voxel_m)
    : inverse_voxel_(static_cast<float>(1.0 / voxel_m)) {
  for (const SurfacePoint& point : points) {
    const auto [entry, added] = index_of_.try_emplace(VoxelKey(point.position, inverse_voxel_),
                                                      static_cast<int>(voxels_.size()));
    if (added) voxels_.emplace_back();
    GaussianVoxel& voxel = voxels_[entry->second];
    ++voxel.count;
    // Running means, which stay accurate far from the origin.
    const float share = 1.0f / static_cast<float>(voxel.count);
    voxel.mean += share * (point.position - voxel.mean);
    voxel.normal += share * (point.normal - voxel.normal);
    voxel.covariance +=
        share * (DiscCovariance(point.normal, AcrossCovariance(point)) - voxel.covariance);
  }
}

const GaussianVoxel* GaussianVoxelMap::Find(const Eigen::Vector3f& p) const {
  const auto entry = index_of_.find(VoxelKey(p, inverse_voxel_));
  return entry == index_of_.end() ? nullptr : &voxels_[entry->second];
}

void FindVgicpPairs(const GaussianVoxelMap& a, const std::vector<SurfacePoint>& b,
                    const std::vector<int>& sample, const Pose& T_a_b,
                    std::vector<Correspondence>* pairs) {
  pairs->clear();
  std::vector<int> counts;
  const Eigen::Matrix3f R = T_a_b.RotationMatrix().cast<float>();
  const Eigen::Vector3f t = T_a_b.translation().cast<float>();
  for (int i : sample) {
    const GaussianVoxel* voxel = a.Find(R * b[i].position + t);
    if (voxel == nullptr) continue;
    const Eigen::Vector3f n = R * b[i].normal;
    if (n.dot(voxel->normal) < kMinNormalCosine * voxel->normal.norm()) continue;
    const Eigen::Matrix3f C = voxel->covariance + DiscCovariance(n, AcrossCovariance(b[i]));
    pairs->push_back(
        {b[i].position.cast<double>(), voxel->mean.cast<double>(), C.inverse().cast<double>()});
    counts.push_back(voxel->count);
  }
  ApplyRobustWeights(T_a_b, kNoiseFloor, pairs);
  for (size_t i = 0; i < counts.size(); ++i) (*pairs)[i].weight *= counts[i];
}

}  // namespace isthmus::matching
