#include "core/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isthmus {
namespace {

// The 4x4 matrix of a twist, [phi]x and rho, whose matrix exponential Exp must be.
Eigen::Matrix4d Hat(const Vector6d& twist) {
  Eigen::Matrix4d hat = Eigen::Matrix4d::Zero();
  hat.topLeftCorner<3, 3>() = Skew(twist.tail<3>());
  hat.topRightCorner<3, 1>() = twist.head<3>();
  return hat;
}

// The power series itself.
Eigen::Matrix4d MatrixExponential(const Eigen::Matrix4d& a) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = sum;
  for (int k = 1; k < 60; ++k) {
    term = term * a / k;
    sum += term;
  }
  return sum;
}

Vector6d RandomTwist(std::mt19937& random, double angle) {
  std::normal_distribution<double> normal;
  Vector6d twist;
  for (int i = 0; i < 6; ++i) twist[i] = normal(random);
  twist.tail<3>() *= angle / twist.tail<3>().norm();
  return twist;
}

constexpr double kAngles[] = {0, 1e-12, 1e-8, 0.9e-5, 1.1e-5, 1e-4, 1e-3, 0.1, 1, 2, 3.1, 3.1415};

TEST(Pose, ExpIsTheMatrixExponential) {
  std::mt19937 random(1);
  for (const double angle : kAngles) {
    const Vector6d twist = RandomTwist(random, angle);
    const Eigen::Matrix4d error = Exp(twist).Matrix() - MatrixExponential(Hat(twist));
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-10) << angle;
  }
}

TEST(Pose, LogIsTheInverseOfExp) {
  std::mt19937 random(2);
  for (const double angle : kAngles) {
    for (int trial = 0; trial < 20; ++trial) {
      const Vector6d twist = RandomTwist(random, angle);
      // Near pi the axis is found from a vanishing part of the quaternion.
      const double tolerance = angle > 3.14 ? 1e-7 : 1e-9;
      EXPECT_LT((Log(Exp(twist)) - twist).norm(), tolerance * (1 + twist.norm())) << angle;
    }
  }
}

TEST(Pose, LogDoesNotMindTheSignOfTheQuaternion) {
  const Pose pose = Pose::FromXyzRpy(1, 2, 3, 0.4, -0.5, 0.6);
  Eigen::Quaterniond negated = pose.rotation();
  negated.coeffs() = -negated.coeffs();
  EXPECT_LT((Log(Pose(negated, pose.translation())) - Log(pose)).norm(), 1e-12);
}

// d/dt Exp(t xi) at t = 0 is the twist's matrix, whatever the base: Exp((t + dt) xi) = Exp(t xi)
// Exp(dt xi).
TEST(Pose, ExpHasTheDerivativeOfItsGenerator) {
  std::mt19937 random(3);
  constexpr double kStep = 1e-6;
  for (const double t : {0.0, 0.3, 1.0}) {
    const Vector6d twist = RandomTwist(random, 1.2);
    const Eigen::Matrix4d numeric =
        (Exp((t + kStep) * twist).Matrix() - Exp((t - kStep) * twist).Matrix()) / (2 * kStep);
    const Eigen::Matrix4d analytic = Exp(t * twist).Matrix() * Hat(twist);
    EXPECT_LT((numeric - analytic).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(Pose, InverseAndProductMakeIdentity) {
  const Pose T_a_b = Pose::FromXyzRpy(1, -2, 3, 0.4, -0.5, 2.6);
  const Pose T_b_c = Pose::FromXyzRpy(-7, 2, 0.3, -0.1, 0.2, -3);
  EXPECT_LT(Log(T_a_b * T_a_b.Inverse()).norm(), 1e-12);
  const Eigen::Vector3d p(0.3, 5, -2);
  EXPECT_LT(((T_a_b * T_b_c) * p - T_a_b * (T_b_c * p)).norm(), 1e-12);
  EXPECT_LT(((T_a_b * T_b_c).Matrix() - T_a_b.Matrix() * T_b_c.Matrix()).norm(), 1e-12);
}

TEST(Pose, MatrixRoundTrips) {
  const Pose pose = Pose::FromXyzRpy(1, -2, 3, 0.4, -0.5, 2.6);
  EXPECT_LT(Log(Pose::FromMatrix(pose.Matrix()).Inverse() * pose).norm(), 1e-12);
}

TEST(Pose, StaysNormalisedThroughManyProducts) {
  const Pose step = Pose::FromXyzRpy(0.1, 0, 0, 0.01, 0.02, 0.03);
  Pose pose;
  for (int i = 0; i < 100'000; ++i) pose = pose * step;
  EXPECT_NEAR(pose.rotation().norm(), 1, 1e-12);
}

TEST(Pose, YawIsTheHeading) {
  for (const double yaw : {-3.1, -1.0, 0.0, 2.0, 3.1}) {
    EXPECT_NEAR(Pose::FromXyzRpy(1, 2, 3, 0.2, -0.3, yaw).Yaw(), yaw, 1e-12);
  }
}

TEST(Pose, InterpolatesAlongTheGeodesic) {
  const Pose from = Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 3.0);
  const Pose to = Pose::FromXyzRpy(2, 1, 3, 0.1, 0.1, -3.0);  // Across the cut of the yaw.
  EXPECT_LT(Log(Interpolate(from, to, 0).Inverse() * from).norm(), 1e-12);
  EXPECT_LT(Log(Interpolate(from, to, 1).Inverse() * to).norm(), 1e-12);
  const Pose half = Interpolate(from, to, 0.5);
  EXPECT_LT((Log(from.Inverse() * half) - Log(half.Inverse() * to)).norm(), 1e-12);
  EXPECT_LT(RotationAngle(from.Inverse() * half), 0.2);
  // Constant speed, outside as well.
  const Pose beyond = Interpolate(from, to, 1.5);
  EXPECT_LT((Log(to.Inverse() * beyond) - Log(from.Inverse() * half)).norm(), 1e-12);
}

TEST(Pose, RotationAngleIsBetweenZeroAndPi) {
  EXPECT_EQ(RotationAngle(Pose(Eigen::Vector3d(1, 2, 3))), 0);
  EXPECT_NEAR(RotationAngle(Pose::FromXyzRpy(0, 0, 0, 0, 0, -3)), 3, 1e-12);
  EXPECT_NEAR(RotationAngle(Pose::FromXyzRpy(0, 0, 0, 0, 0, 4)), 2 * M_PI - 4, 1e-12);
}

TEST(Pose, KnowsWhetherItIsFinite) {
  EXPECT_TRUE(Pose().IsFinite());
  EXPECT_FALSE(Pose(Eigen::Vector3d(0, std::nan(""), 0)).IsFinite());
  EXPECT_FALSE(Pose(Eigen::Quaterniond(std::nan(""), 0, 0, 0), Eigen::Vector3d::Zero()).IsFinite());
}

}  // namespace
}  // namespace isthmus
