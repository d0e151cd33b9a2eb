#include "floam/match/match_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "floam/match/limits.h"

namespace isthmus::floam {
namespace {

// Shares of the information about a direction.
struct Shares {
  // The share left if any kWrongMatches of the matches are wrong: these have sqrt(kWrongMatches Sum
  // c^2) of Sum c at most, c the contribution of each.
  double trustworthy = 1;
  // The same of matches whose points move along their normals rather than across.
  double plain = 1;
};

Shares SharesOf(const std::vector<MatchRow>& rows, const Vector6d& direction) {
  double sum = 0, sum2 = 0, plain = 0, plain2 = 0;
  for (const MatchRow& row : rows) {
    const double along = row.jacobian.dot(direction);
    const double contribution = row.weight * along * along;
    sum += contribution;
    sum2 += contribution * contribution;
    const Eigen::Vector3d moved = direction.head<3>() + direction.tail<3>().cross(row.q);
    if (along * along < kPlainCosine * kPlainCosine * moved.squaredNorm()) continue;
    plain += contribution;
    plain2 += contribution * contribution;
  }
  if (sum <= 0) return {0, 0};
  return {std::max(0.0, 1 - std::sqrt(kWrongMatches * sum2) / sum),
          std::max(0.0, plain - std::sqrt(kWrongMatches * plain2)) / sum};
}

}  // namespace

Matrix6d Isotropic(double sigma_m, double sigma_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

JointEstimate Solve(const MatchSums& sums, const std::vector<MatchRow>& rows, const Matrix6d& prior,
                    const Vector6d& offset) {
  const Matrix12d& H = sums.information;
  const Vector12d& g = sums.gradient;
  // The twist follows from the pose: what remains is about the pose alone.
  const Eigen::LLT<Matrix6d> twist(Matrix6d(H.bottomRightCorner<6, 6>()));
  const Matrix6d follow = twist.solve(Matrix6d(H.bottomLeftCorner<6, 6>()));
  const Matrix6d A = H.topLeftCorner<6, 6>() - H.topRightCorner<6, 6>() * follow;
  const Vector6d b = g.head<6>() - follow.transpose() * g.tail<6>();

  const Matrix6d L = prior.llt().matrixL();
  const Matrix6d whitened = L.transpose() * A * L;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(0.5 * (whitened + whitened.transpose()));
  const Matrix6d directions = L * solver.eigenvectors();
  const Vector6d slope = directions.transpose() * (b - sums.noise_gradient);
  const Vector6d from_noise = (directions.transpose() * sums.noise * directions).diagonal();
  const Vector6d away =
      solver.eigenvectors().transpose() * L.triangularView<Eigen::Lower>().solve(offset);
  Vector6d move, left, told;
  for (int k = 0; k < 6; ++k) {
    const double all = std::max(solver.eigenvalues()[k], 0.0);
    const Shares shares = all < kCertainRatio ? SharesOf(rows, directions.col(k)) : Shares();
    const double honest = std::max(all - from_noise[k], 0.0);
    const double known = shares.trustworthy * honest;
    told[k] = shares.plain * honest;
    left[k] = 1 / (known + 1);
    move[k] = -left[k] * ((known > 0 ? shares.trustworthy * slope[k] : 0) + away[k]);
  }
  JointEstimate estimate;
  const Vector6d step = directions * move;
  estimate.step << step, -follow * step - twist.solve(Vector6d(g.tail<6>()));
  const Matrix6d pose = directions * left.asDiagonal() * directions.transpose();
  const Matrix6d mixed = -pose * follow.transpose();
  const Matrix6d rest = twist.solve(Matrix6d::Identity()) + follow * pose * follow.transpose();
  estimate.covariance << pose, mixed, mixed.transpose(), rest;
  const Matrix6d back = L.transpose().triangularView<Eigen::Upper>().solve(solver.eigenvectors());
  estimate.match_information = back * told.asDiagonal() * back.transpose();
  return estimate;
}

}  // namespace isthmus::floam
