#include "floam/match/pose_covariance.h"

#include <gtest/gtest.h>

namespace isthmus::floam {
namespace {

MatchResult SomeMatch() {
  MatchResult match;
  match.pose.T_odom_sensor = Pose::FromXyzRpy(3, -2, 1, 0.1, 0.05, 2);
  match.pose.twist << 1.2, 0.1, 0, 0.05, -0.1, 0.8;
  match.pose.reference_s = -0.05;
  return match;
}

// The END by a change of pose and twist, from differences.
Eigen::Matrix<double, 6, 12> NumericJacobian(const ScanPose& pose) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 12> J;
  for (int k = 0; k < 12; ++k) {
    ScanPose changed = pose;
    if (k < 6) {
      changed.T_odom_sensor = pose.T_odom_sensor * Exp(kStep * Vector6d::Unit(k));
    } else {
      changed.twist[k - 6] += kStep;
    }
    J.col(k) = Log(pose.At(0).Inverse() * changed.At(0)) / kStep;
  }
  return J;
}

TEST(MatchedCovarianceAtEnd, FollowsFromThatOfThePose) {
  MatchResult match = SomeMatch();
  const Vector12d sigma = Vector12d::LinSpaced(12, 0.01, 0.12);
  match.covariance = sigma.cwiseAbs2().asDiagonal();
  const Eigen::Matrix<double, 6, 6> J = NumericJacobian(match.pose).leftCols<6>();
  const Matrix6d expected = J * match.covariance.topLeftCorner<6, 6>() * J.transpose();
  EXPECT_TRUE(MatchedCovarianceAtEnd(match, false).isApprox(expected, 1e-5));
}

TEST(MatchedCovarianceAtEnd, GrowsByWhatIsNotKnownOfTheTwist) {
  for (const int axis : {0, 1, 5}) {
    MatchResult match = SomeMatch();
    match.covariance(6 + axis, 6 + axis) = 0.04;
    const Vector6d column = NumericJacobian(match.pose).col(6 + axis);
    const Matrix6d expected = 0.04 * column * column.transpose();
    // The left Jacobian of the motion to the END is taken as identity.
    EXPECT_LT((MatchedCovarianceAtEnd(match, true) - expected).norm(), 0.05 * expected.norm())
        << axis;
  }
}

TEST(Widened, IsWideAlongWhatTheMapDoesNotTell) {
  MatchResult match = SomeMatch();
  match.covariance = 1e-6 * Matrix12d::Identity();
  const Eigen::Vector3d along = Eigen::Vector3d(1, 1, 0).normalized();
  match.map_degeneracy.translations = {along};
  const Degeneracy at_end = DegeneracyAtEnd(match);
  ASSERT_EQ(at_end.translations.size(), 1u);
  const Eigen::Matrix3d covariance =
      Widened(MatchedCovarianceAtEnd(match, false), at_end).topLeftCorner<3, 3>();
  const Eigen::Vector3d& d = at_end.translations[0];
  const Eigen::Vector3d across = d.unitOrthogonal();
  EXPECT_GT(d.dot(covariance * d), 0.9);
  EXPECT_LT(across.dot(covariance * across), 1e-3);
}

}  // namespace
}  // namespace isthmus::floam
