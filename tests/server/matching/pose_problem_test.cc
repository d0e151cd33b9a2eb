#include "server/matching/registration/pose_problem.h"

#include <gtest/gtest.h>

#include <random>

namespace isthmus::matching {
namespace {

std::vector<Correspondence> RandomPairs(const Pose& T_a_b, double noise, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(x, y, z);
  };
  std::vector<Correspondence> pairs;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p = 5 * vector(), u = vector(), v = vector();
    pairs.push_back({p, T_a_b * p + noise * vector(),
                     Eigen::Matrix3d::Identity() + u * u.transpose() + v * v.transpose()});
  }
  return pairs;
}

const Pose kTrueMotion = Pose::FromXyzRpy(12, -7, 1, 0.1, -0.2, 2.0);

TEST(PoseProblem, GradientEqualsNumericalDerivativeOfTheCost) {
  const auto pairs = RandomPairs(kTrueMotion, 0.3, 1);
  const Eigen::Vector3d center(10, -5, 2);
  const NormalEquations equations = Linearize(pairs, kTrueMotion, center);
  for (int i = 0; i < 6; ++i) {
    const double h = 1e-5;
    const Vector6d step = h * Vector6d::Unit(i);
    const double plus = Linearize(pairs, MoveAbout(center, step, kTrueMotion), center).cost;
    const double minus = Linearize(pairs, MoveAbout(center, -step, kTrueMotion), center).cost;
    EXPECT_NEAR(equations.g[i], (plus - minus) / (2 * h), 1e-4 * equations.g.norm()) << i;
  }
}

TEST(PoseProblem, HessianEqualsNumericalDerivativeOfTheGradientWithoutNoise) {
  // With zero residuals Gauss-Newton's Hessian is the exact one.
  const auto pairs = RandomPairs(kTrueMotion, 0, 2);
  const Eigen::Vector3d center(10, -5, 2);
  const NormalEquations equations = Linearize(pairs, kTrueMotion, center);
  for (int i = 0; i < 6; ++i) {
    const double h = 1e-5;
    const Vector6d step = h * Vector6d::Unit(i);
    const Vector6d plus = Linearize(pairs, MoveAbout(center, step, kTrueMotion), center).g;
    const Vector6d minus = Linearize(pairs, MoveAbout(center, -step, kTrueMotion), center).g;
    const Vector6d column = (plus - minus) / (2 * h);
    EXPECT_LT((equations.H.col(i) - column).norm(), 1e-3 * equations.H.norm()) << i;
  }
}

TEST(PoseProblem, StepsReachTheTruth) {
  const auto pairs = RandomPairs(kTrueMotion, 0, 3);
  Pose T = kTrueMotion * Pose::FromXyzRpy(1, -2, 0.5, 0.2, -0.1, 0.3);
  Vector6d twist;
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(StepPose(pairs, 1e-9, &T, &twist));
  EXPECT_LT(Log(kTrueMotion.Inverse() * T).norm(), 1e-9);
}

TEST(PoseProblem, UnseenDirectionsStayWhereTheyAre) {
  auto pairs = RandomPairs(Pose(), 0, 4);
  for (Correspondence& pair : pairs) pair.weight = Eigen::Vector3d(0, 1, 1).asDiagonal();
  Pose T(Eigen::Vector3d(0.7, 0.2, -0.1));
  Vector6d twist;
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(StepPose(pairs, 1e-6, &T, &twist));
  EXPECT_NEAR(T.translation().x(), 0.7, 0.01);
  EXPECT_NEAR(T.translation().y(), 0, 1e-4);
  EXPECT_NEAR(T.translation().z(), 0, 1e-4);
}

TEST(PoseProblem, TooFewPairsAreRefused) {
  auto pairs = RandomPairs(Pose(), 0.1, 5);
  pairs.resize(5);
  Pose T;
  Vector6d twist = Vector6d::Ones();
  EXPECT_FALSE(StepPose(pairs, 1e-6, &T, &twist));
  EXPECT_EQ(T.Matrix(), Pose().Matrix());
}

TEST(PoseProblem, InformationMovesToTheOriginAsIfComputedThere) {
  const auto pairs = RandomPairs(kTrueMotion, 0.1, 6);
  const Eigen::Vector3d center(10, -5, 2);
  const Matrix6d there = Linearize(pairs, kTrueMotion, center).H;
  const Matrix6d here = Linearize(pairs, kTrueMotion, Eigen::Vector3d::Zero()).H;
  EXPECT_LT((MoveInformationToOrigin(there, center) - here).norm(), 1e-9 * here.norm());
}

}  // namespace
}  // namespace isthmus::matching
