#include "floam/match/unobserved_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isthmus::floam {
namespace {

Degeneracy Along(const Eigen::Vector3d& d) {
  Degeneracy unobserved;
  unobserved.translations = {d};
  return unobserved;
}

Matrix6d SumOfSteps(UnobservedMotion* motion, const Degeneracy& unobserved, int steps,
                    double elapsed_s) {
  Matrix6d sum = Matrix6d::Zero();
  for (int k = 0; k < steps; ++k) sum += motion->Step(unobserved, elapsed_s);
  return sum;
}

TEST(UnobservedMotion, IsNoneWhereAllIsObserved) {
  UnobservedMotion motion;
  EXPECT_TRUE(motion.Step(Degeneracy(), 0.1).isZero(0));
}

TEST(UnobservedMotion, LastsForHalfASecondWhereverTheSensorTurns) {
  UnobservedMotion motion;
  const Eigen::Matrix3d ahead = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d left = Pose::FromXyzRpy(0, 0, 0, 0, 0, EIGEN_PI / 2).RotationMatrix();
  EXPECT_FALSE(motion.Lasting(Degeneracy(), ahead, 0.1).any());
  motion.Lasting(Along(Eigen::Vector3d::UnitX()), ahead, 0.1);
  for (int k = 0; k < 5; ++k) {
    const Degeneracy lasting = motion.Lasting(Degeneracy(), left, 0.1);
    ASSERT_EQ(lasting.translations.size(), 1u) << k;
    EXPECT_TRUE(lasting.translations[0].isApprox(-Eigen::Vector3d::UnitY()));
    EXPECT_TRUE(lasting.rotations.empty());
  }
  EXPECT_FALSE(motion.Lasting(Degeneracy(), left, 0.1).any());
}

TEST(UnobservedMotion, GrowsAlongTheUnobservedDirectionAlone) {
  const Eigen::Vector3d d = Eigen::Vector3d(1, 2, 0).normalized();
  UnobservedMotion motion;
  const Matrix6d sum = SumOfSteps(&motion, Along(d), 10, 0.1);
  EXPECT_NEAR(d.dot(sum.topLeftCorner<3, 3>() * d), 1.0 / 3, 1e-12);
  EXPECT_NEAR(sum.trace(), 1.0 / 3, 1e-12);
  Degeneracy yaw;
  yaw.rotations = {Eigen::Vector3d::UnitZ()};
  UnobservedMotion turning;
  const Matrix6d turned = SumOfSteps(&turning, yaw, 10, 0.1);
  EXPECT_NEAR(turned(5, 5), 0.1 / 3, 1e-12);
  EXPECT_NEAR(turned.trace(), 0.1 / 3, 1e-12);
}

TEST(UnobservedMotion, DoesNotDependOnHowManyScansThereWere) {
  for (const double total_s : {0.6, 3.0}) {
    UnobservedMotion a, b;
    const Degeneracy x = Along(Eigen::Vector3d::UnitX());
    EXPECT_NEAR(SumOfSteps(&a, x, 3, total_s / 3)(0, 0), SumOfSteps(&b, x, 30, total_s / 30)(0, 0),
                1e-12);
  }
}

// The sums stand for a speed that does a random walk, and the way that comes of it.
TEST(UnobservedMotion, IsThatOfWhiteAcceleration) {
  constexpr int kTrials = 4000, kSteps = 100;
  constexpr double kStepS = 0.8 / kSteps;
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  double sum2 = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    double speed = 0, path_length = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double change = std::sqrt(kStepS) * gauss(random);
      path_length += (speed + 0.5 * change) * kStepS;
      speed += change;
    }
    sum2 += path_length * path_length;
  }
  UnobservedMotion motion;
  const double variance = SumOfSteps(&motion, Along(Eigen::Vector3d::UnitX()), 8, 0.1)(0, 0);
  EXPECT_NEAR(sum2 / kTrials, variance, 0.1 * variance);
}

TEST(UnobservedMotion, OfALongTunnelGrowsEvenly) {
  UnobservedMotion motion;
  const Degeneracy x = Along(Eigen::Vector3d::UnitX());
  EXPECT_NEAR(SumOfSteps(&motion, x, 50, 0.1)(0, 0), 1.0 / 3 + 4, 1e-9);
  EXPECT_NEAR(SumOfSteps(&motion, x, 50, 0.1)(0, 0), 5, 1e-9);
}

TEST(UnobservedMotion, BeginsAnewWhenSomethingWasSeen) {
  UnobservedMotion motion;
  const Degeneracy x = Along(Eigen::Vector3d::UnitX());
  const double first = SumOfSteps(&motion, x, 5, 0.1)(0, 0);
  const double going_on = motion.Step(x, 0.1)(0, 0);
  motion.Step(Degeneracy(), 0.1);
  EXPECT_NEAR(SumOfSteps(&motion, x, 5, 0.1)(0, 0), first, 1e-12);
  EXPECT_GT(going_on, 2 * first / 5);
}

TEST(UnobservedMotion, OfALostRobotIsInEveryDirection) {
  UnobservedMotion motion;
  Matrix6d sum = Matrix6d::Zero();
  for (int k = 0; k < 20; ++k) sum += motion.LostStep(0.1);
  EXPECT_TRUE(sum.isDiagonal());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum(axis, axis), 1.0 / 3 + 1, 1e-9);
    EXPECT_NEAR(sum(3 + axis, 3 + axis), 0.1 / 3 + 0.1, 1e-9);
  }
  // Found somewhere else altogether, it may be anywhere.
  EXPECT_GE(motion.StepAfterRelocalisation().diagonal().head<3>().minCoeff(), 25);
  EXPECT_TRUE(motion.Step(Degeneracy(), 0.1).isZero(0));
}

}  // namespace
}  // namespace isthmus::floam
