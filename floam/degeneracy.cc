#include "floam/degeneracy.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

namespace isthmus::floam {
namespace {

constexpr double kRotationShare = 1.0 / 30;

// Information about the first part once the second is free, symmetric.
Eigen::Matrix3d Schur(const Eigen::Matrix3d& first, const Eigen::Matrix3d& mixed,
                      const Eigen::Matrix3d& second) {
  // The regularisation only matters where `second` is singular: there nothing can follow.
  const Eigen::Matrix3d regular =
      second + (1e-9 * second.trace() + 1e-12) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d schur = first - mixed * regular.inverse() * mixed.transpose();
  return 0.5 * (schur + schur.transpose());
}

double CollectWeak(const Eigen::Matrix3d& schur, double least,
                   std::vector<Eigen::Vector3d>* directions) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(schur);
  for (int k = 0; k < 3; ++k) {
    if (solver.eigenvalues()[k] < least) directions->push_back(solver.eigenvectors().col(k));
  }
  return solver.eigenvalues()[0];
}

}  // namespace

Degeneracy FindDegeneracy(const Matrix6d& information, int used, double lever_m,
                          double least_share) {
  const Eigen::Matrix3d translation = information.topLeftCorner<3, 3>();
  const Eigen::Matrix3d rotation = information.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d mixed = information.topRightCorner<3, 3>();
  const double matches = std::max(used, 1);
  const double lever2 = lever_m * lever_m;
  Degeneracy result;
  result.weakest_translation =
      CollectWeak(Schur(translation, mixed, rotation) / matches, least_share, &result.translations);
  result.weakest_rotation =
      CollectWeak(Schur(rotation, mixed.transpose(), translation) / (matches * lever2),
                  kRotationShare * least_share, &result.rotations);
  return result;
}

}  // namespace isthmus::floam
