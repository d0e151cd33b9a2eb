#include "server/matching/search/gravity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

// One class of surfaces: the mean of n n^T over those within the gate.
struct Scatter {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  size_t count = 0;

  void Add(const Eigen::Vector3d& n) {
    sum.noalias() += n * n.transpose();
    ++count;
  }
  Eigen::Matrix3d Mean() const {
    return count ? Eigen::Matrix3d(sum / static_cast<double>(count)) : Eigen::Matrix3d::Zero();
  }
};

}  // namespace

Eigen::Quaterniond EstimateLevel(const std::vector<SurfacePoint>& surface, double max_tilt_rad) {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (int round = 0; round < kLevelRounds; ++round) {
    const double gate = std::max(kLevelGateRad, max_tilt_rad * std::pow(0.7, round));
    const double sin_gate = std::sin(gate), cos_gate = std::cos(gate);
    Scatter level, upright;
    for (const SurfacePoint& point : surface) {
      const Eigen::Vector3d n = point.normal.cast<double>();
      const double along = std::abs(n.dot(up));
      if (along > cos_gate) level.Add(n);
      if (along < sin_gate) upright.Add(n);
    }
    if (level.count < kMinLevelSurfaces) return Eigen::Quaterniond::Identity();
    // Minimise |u x n|^2 over level ones plus (u . n)^2 over upright ones, each class as one vote.
    const Eigen::Matrix3d cost = upright.Mean() - level.Mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(cost);
    const Eigen::Vector3d found = solver.eigenvectors().col(0);
    up = found.z() < 0 ? Eigen::Vector3d(-found) : found;
  }
  if (up.z() < std::cos(max_tilt_rad)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

}  // namespace isthmus::matching
