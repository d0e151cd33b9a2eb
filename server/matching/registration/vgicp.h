// Fast VGICP: Koide, Yokozuka, Oishi, Banno, "Voxelized GICP for Fast and Accurate 3D Point Cloud
// Registration", ICRA 2021. Points are compared with the distribution of the voxel they fall into,
// so that no neighbour is ever searched.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <vector>

#include "server/matching/registration/pose_problem.h"
#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// Mean and mean covariance of the surface points in a voxel (Koide et al., eq. 8 and 9).
struct GaussianVoxel {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // Mean; shorter than 1 where surfaces meet.
  int count = 0;
};

// Immutable after construction; safe to read from many threads.
class GaussianVoxelMap {
 public:
  GaussianVoxelMap() = default;
  GaussianVoxelMap(const std::vector<SurfacePoint>& points, double voxel_m);

  // The voxel of the point; null where the map has no surface.
  const GaussianVoxel* Find(const Eigen::Vector3f& p) const;
  size_t size() const { return voxels_.size(); }

 private:
  float inverse_voxel_ = 1;
  absl::flat_hash_map<uint64_t, int> index_of_;
  std::vector<GaussianVoxel> voxels_;
};

// Pairs every b[i], i in `sample`, with the voxel it falls into (eq. 10: the voxel's count weighs
// it), unless their normals differ by more than 60 degrees; robust weights as in gicp.h.
void FindVgicpPairs(const GaussianVoxelMap& a, const std::vector<SurfacePoint>& b,
                    const std::vector<int>& sample, const Pose& T_a_b,
                    std::vector<Correspondence>* pairs);

}  // namespace isthmus::matching
