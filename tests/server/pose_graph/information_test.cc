#include "server/pose_graph/information.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/se3.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

// Not diagonal, and of very unlike scales: its L and L^T weigh errors quite differently.
Matrix6d Slanted() {
  Matrix6d L = Matrix6d::Identity();
  L(0, 0) = 100;
  L(3, 0) = 40;
  L(5, 0) = -70;
  L(5, 4) = 3;
  return L * L.transpose();
}

TEST(SquareRootInformation, IsTheRightWayRound) {
  const Matrix6d information = Slanted();
  const Matrix6d W = *SquareRootInformation(information);
  for (int i = 0; i < 6; ++i) {
    const Vector6d e = Vector6d::Unit(i);
    EXPECT_NEAR((W * e).squaredNorm(), e.dot(information * e), 1e-9 * information.norm());
  }
  EXPECT_LT((W.transpose() * W - information).norm(), 1e-9 * information.norm());
  // The other way round is another matrix, so that the above tells them apart.
  EXPECT_GT((W * W.transpose() - information).norm(), 0.1 * information.norm());
}

TEST(SquareRootInformation, TakesDirectionsWithoutInformation) {
  const Vector6d blind = (Vector6d() << 0.6, 0, 0, 0, 0.8, 0).finished();
  const Matrix6d P = Matrix6d::Identity() - blind * blind.transpose();
  const Matrix6d information = P * Slanted() * P;
  const Matrix6d W = *SquareRootInformation(information);
  EXPECT_LT((W.transpose() * W - information).norm(), 1e-9 * information.norm());
  EXPECT_LT((W * blind).norm(), 1e-5);
  EXPECT_EQ(*SquareRootInformation(Matrix6d::Zero()), Matrix6d::Zero());
}

TEST(SquareRootInformation, RefusesWhatIsNone) {
  Matrix6d nan = Matrix6d::Identity();
  nan(2, 3) = nan(3, 2) = std::nan("");
  Matrix6d lopsided = Matrix6d::Identity();
  lopsided(0, 5) = 0.1;
  Matrix6d negative = Matrix6d::Identity();
  negative(4, 4) = -0.1;
  for (const Matrix6d& m : {nan, lopsided, negative}) {
    const auto root = SquareRootInformation(m);
    EXPECT_EQ(root.status().code(), absl::StatusCode::kInvalidArgument) << root.status();
  }
}

TEST(OdometryInformation, ShrinksWithDistanceAndTurn) {
  const auto sigma = [](const Pose& T, int i) {
    return std::sqrt(Matrix6d(OdometryInformation(T).inverse())(i, i));
  };
  EXPECT_NEAR(sigma(Pose(), 0), 0.01, 1e-9);
  EXPECT_NEAR(sigma(Pose(), 5), 0.00175, 1e-9);
  const Pose straight(Eigen::Vector3d(10, 0, 0));
  EXPECT_NEAR(sigma(straight, 0), 0.06, 1e-9);
  EXPECT_NEAR(sigma(straight, 5), 0.00175 + 0.0035, 1e-9);
  const Pose turned = Pose::FromXyzRpy(0, 0, 0, 0, 0, 1);
  EXPECT_NEAR(sigma(turned, 5), 0.00175 + 0.005, 1e-9);
}

// A turning error of s half way displaces a node 10 m on by s * 5 m.
TEST(OdometryInformation, TurningErrorsDisplaceTheFarNode) {
  const Pose T_a_b(Eigen::Vector3d(10, 0, 0));
  const Matrix6d covariance = OdometryInformation(T_a_b).inverse();
  // The true pose is Exp(twist) T_a_b: the far node moves by rho + phi x t.
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -Skew(T_a_b.translation());
  const Eigen::Matrix3d moved = J * covariance * J.transpose();
  EXPECT_NEAR(std::sqrt(moved(1, 1)), std::hypot(0.06, 5 * (0.00175 + 0.0035)), 1e-9);
  EXPECT_NEAR(std::sqrt(moved(0, 0)), 0.06, 1e-9);
}

TEST(OdometryInformation, IsAnInformationWhateverTheModel) {
  EXPECT_TRUE(SquareRootInformation(OdometryInformation(Pose(), {0, 0, 0, 0, 0})).ok());
  const Pose far(Eigen::Vector3d(1000, -500, 3));
  const Matrix6d information = OdometryInformation(far, 3000, 50);
  EXPECT_TRUE(SquareRootInformation(information).ok());
  EXPECT_LT(information(5, 5), OdometryInformation(far)(5, 5));
}

}  // namespace
}  // namespace isthmus::pose_graph
