#include "floam/match/degeneracy.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace isthmus::floam {
namespace {

std::vector<Eigen::Vector3d> Unobserved(const Eigen::Matrix3d& posterior,
                                        const Eigen::Matrix3d& prior) {
  const Eigen::Matrix3d L = prior.llt().matrixL();
  const Eigen::Matrix3d L_inverse = L.inverse();
  const Eigen::Matrix3d left = L_inverse * posterior * L_inverse.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(left);
  std::vector<Eigen::Vector3d> directions;
  for (int k = 0; k < 3; ++k) {
    // As much is known by the matches as by the prior.
    if (solver.eigenvalues()[k] <= 0.5) continue;
    directions.push_back((L * solver.eigenvectors().col(k)).normalized());
  }
  return directions;
}

}  // namespace

Degeneracy Everything() {
  Degeneracy degeneracy;
  for (int axis = 0; axis < 3; ++axis) {
    degeneracy.translations.push_back(Eigen::Vector3d::Unit(axis));
    degeneracy.rotations.push_back(Eigen::Vector3d::Unit(axis));
  }
  return degeneracy;
}

Degeneracy Rotated(const Eigen::Matrix3d& R, Degeneracy degeneracy) {
  for (Eigen::Vector3d& d : degeneracy.translations) d = R * d;
  for (Eigen::Vector3d& d : degeneracy.rotations) d = R * d;
  return degeneracy;
}

void Widen(const Degeneracy& degeneracy, double translation, double rotation,
           Matrix6d* covariance) {
  for (const Eigen::Vector3d& d : degeneracy.translations) {
    covariance->topLeftCorner<3, 3>() += translation * d * d.transpose();
  }
  for (const Eigen::Vector3d& d : degeneracy.rotations) {
    covariance->bottomRightCorner<3, 3>() += rotation * d * d.transpose();
  }
}

Degeneracy FindDegeneracy(const Matrix6d& information, const Matrix6d& prior) {
  const Matrix6d posterior = (information + prior.inverse()).inverse();
  return {Unobserved(posterior.topLeftCorner<3, 3>(), prior.topLeftCorner<3, 3>()),
          Unobserved(posterior.bottomRightCorner<3, 3>(), prior.bottomRightCorner<3, 3>())};
}

}  // namespace isthmus::floam
