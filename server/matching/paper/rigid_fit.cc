#include "server/matching/paper/rigid_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace isthmus::matching {

Pose FitRigid(std::span<const PointPair> pairs) {
  if (pairs.empty()) return Pose();
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    mean_a += pair.a.cast<double>();
    mean_b += pair.b.cast<double>();
  }
  mean_a /= static_cast<double>(pairs.size());
  mean_b /= static_cast<double>(pairs.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    covariance.noalias() +=
        (pair.a.cast<double>() - mean_a) * (pair.b.cast<double>() - mean_b).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return Pose(Eigen::Quaterniond(R), mean_a - R * mean_b);
}

}  // namespace isthmus::matching
