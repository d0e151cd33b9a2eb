#include "floam/match/pose_covariance.h"

#include "core/geometry/se3.h"
#include "floam/match/limits.h"

namespace isthmus::floam {
namespace {

// The twist's prior is wide enough for speed bumps; on most scans height and tilt change far less
// than it allows, and what it leaves open is this share of what the covariance says.
Vector6d TwistShare() { return (Vector6d() << 1, 1, 0.4, 0.4, 0.4, 1).finished(); }

}  // namespace

Matrix6d MatchedCovarianceAtEnd(const MatchResult& match, bool with_twist) {
  const double ahead_s = -match.pose.reference_s;
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.leftCols<6>() = Adjoint(Exp(-ahead_s * match.pose.twist));
  if (with_twist) J.rightCols<6>() = ahead_s * TwistShare().asDiagonal().toDenseMatrix();
  return J * match.covariance * J.transpose();
}

Degeneracy DegeneracyAtEnd(const MatchResult& match) {
  const Eigen::Matrix3d R_end_reference =
      Exp(match.pose.reference_s * match.pose.twist).RotationMatrix();
  return Rotated(R_end_reference, match.map_degeneracy);
}

Matrix6d Widened(const Matrix6d& covariance, const Degeneracy& unobserved) {
  Matrix6d wide = covariance;
  Widen(unobserved, kUnobservedM * kUnobservedM, kUnobservedRad * kUnobservedRad, &wide);
  return wide;
}

Matrix6d LostCovariance() {
  Vector6d variance;
  variance.head<3>().setConstant(kLostM * kLostM);
  variance.tail<3>().setConstant(kLostRad * kLostRad);
  return variance.asDiagonal();
}

}  // namespace isthmus::floam
