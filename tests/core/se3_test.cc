#include "core/geometry/se3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace isthmus {
namespace {

// A twist of that length and angle, in any direction.
Vector6d TwistOf(double distance, double angle, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    return Eigen::Vector3d(normal(*random), normal(*random), normal(*random)).normalized();
  };
  Vector6d twist;
  twist << distance * direction(), angle * direction();
  return twist;
}

// Columns d f(d) / d d_i at zero, by central differences.
Matrix6d Numeric(const std::function<Vector6d(const Vector6d&)>& f) {
  constexpr double kStep = 1e-6;
  Matrix6d J;
  for (int i = 0; i < 6; ++i) {
    const Vector6d d = kStep * Vector6d::Unit(i);
    J.col(i) = (f(d) - f(-d)) / (2 * kStep);
  }
  return J;
}

// Twists of all sizes of angle: none, tiny, where series are used, and nearly pi.
std::vector<Vector6d> Twists() {
  std::mt19937_64 random(3);
  std::vector<Vector6d> twists = {Vector6d::Zero()};
  for (const double angle : {1e-9, 1e-6, 1e-4, 1e-2, 0.3, 1.0, 2.0, 3.0}) {
    for (int i = 0; i < 5; ++i) twists.push_back(TwistOf(5, angle, &random));
  }
  return twists;
}

TEST(Se3, AdjointMovesTwistsAcross) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose T = Exp(TwistOf(10, 3, &random));
    const Vector6d twist = TwistOf(1, 1, &random);
    const Pose left = Exp(Vector6d(Adjoint(T) * twist)) * T;
    EXPECT_LT(Log(left.Inverse() * (T * Exp(twist))).norm(), 1e-12);
  }
}

TEST(Se3, InverseJacobianIsTheDerivativeOfLog) {
  for (const Vector6d& twist : Twists()) {
    const Matrix6d left = Numeric([&](const Vector6d& d) { return Log(Exp(d) * Exp(twist)); });
    EXPECT_LT((InverseLeftJacobian(twist) - left).cwiseAbs().maxCoeff(), 2e-7);
  }
}

TEST(Se3, InverseOfRotationHoldsBeyondPi) {
  const double angle = 5.5;
  const Eigen::Vector3d axis(0.6, 0, 0.8);
  // Barfoot (2017), eq. 7.77a.
  const double s = std::sin(angle) / angle;
  const Eigen::Matrix3d jacobian = s * Eigen::Matrix3d::Identity() +
                                   (1 - s) * axis * axis.transpose() +
                                   (1 - std::cos(angle)) / angle * Skew(axis);
  const Eigen::Matrix3d product = InverseLeftJacobian(Eigen::Vector3d(angle * axis)) * jacobian;
  EXPECT_LT((product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace isthmus
