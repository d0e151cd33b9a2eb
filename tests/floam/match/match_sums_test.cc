#include "floam/match/match_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace isthmus::floam {
namespace {

Pose SomePose() { return Pose::FromXyzRpy(1.3, -0.4, 0.7, 0.2, -0.1, 2.4); }

TEST(PoseJacobian, AgreesWithNumericalDerivatives) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-5, 5);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d q(uniform(random), uniform(random), uniform(random));
    const Eigen::Vector3d n =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
    const Pose T = SomePose();
    const Vector6d analytic = PoseJacobian(q, T.RotationMatrix().transpose() * n);
    for (int k = 0; k < 6; ++k) {
      const double h = 1e-6;
      const auto distance = [&](double step) {
        return n.dot(T * Exp(step * Vector6d::Unit(k)) * q);
      };
      EXPECT_NEAR(analytic[k], (distance(h) - distance(-h)) / (2 * h), 1e-7);
    }
  }
}

// The derivative by the twist is exact at rest, and to first order in the motion within the scan.
TEST(TwistJacobian, AgreesWithNumericalDerivatives) {
  const Eigen::Vector3d p(4, -2, 1), n = Eigen::Vector3d(1, 2, 3).normalized();
  const Pose T = SomePose();
  const double tau = -0.04;
  for (const double scale : {0.0, 1.0}) {
    const Vector6d twist = scale * (Vector6d() << 1.5, 0.2, 0, 0.05, -0.1, 0.9).finished();
    const Eigen::Vector3d q = Exp(tau * twist) * p;
    const Vector6d analytic = tau * PoseJacobian(q, T.RotationMatrix().transpose() * n);
    const double motion_rad = std::abs(tau) * twist.tail<3>().norm();
    for (int k = 0; k < 6; ++k) {
      const double h = 1e-6;
      const auto distance = [&](double step) {
        return n.dot(T * Exp(tau * (twist + step * Vector6d::Unit(k))) * p);
      };
      const double numeric = (distance(h) - distance(-h)) / (2 * h);
      EXPECT_NEAR(analytic[k], numeric, 1e-8 + motion_rad * analytic.norm()) << k;
    }
  }
}

// The number of rows is one that no number of lanes divides.
class MatchSumsTest : public ::testing::Test {
 protected:
  MatchSumsTest() {
    const auto vector = [&] { return Eigen::Vector3d(draw(), draw(), draw()); };
    for (int k = 0; k < 53; ++k) {
      MatchRow row;
      row.q = 10 * vector();
      row.jacobian = PoseJacobian(row.q, vector().normalized());
      row.weight = 1 + draw();
      row.residual = draw();
      row.tau = 0.05 * draw();
      row.offset = vector();
      row.tilt_variance = 0.01 * (1 + draw());
      rows_.push_back(row);
    }
  }
  double draw() { return uniform_(random_); }

  std::mt19937 random_{5};
  std::uniform_real_distribution<double> uniform_{-1, 1};
  std::vector<MatchRow> rows_;
};

TEST_F(MatchSumsTest, AreTheSumsOfTheirRows) {
  Matrix12d H = Matrix12d::Zero();
  Vector12d g = Vector12d::Zero();
  for (const MatchRow& row : rows_) {
    Vector12d J;
    J << row.jacobian, row.tau * row.jacobian;
    H += row.weight * J * J.transpose();
    g += row.weight * row.residual * J;
  }
  const MatchSums sums = SumOf(rows_, true);
  EXPECT_TRUE(sums.information.isApprox(H, 1e-12));
  EXPECT_TRUE(sums.gradient.isApprox(g, 1e-12));
  const MatchSums pose = SumOf(rows_, false);
  EXPECT_TRUE((pose.information.topLeftCorner<6, 6>().isApprox(H.topLeftCorner<6, 6>(), 1e-12)));
  EXPECT_TRUE(pose.gradient.head<6>().isApprox(g.head<6>(), 1e-12));
  EXPECT_EQ(pose.information.rightCols<6>().norm() + pose.gradient.tail<6>().norm(), 0);
}

TEST_F(MatchSumsTest, NoiseIsTheSumOfTheExpectations) {
  Matrix6d noise = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  for (const MatchRow& row : rows_) {
    const Eigen::Vector3d n = row.jacobian.head<3>();
    Eigen::Matrix<double, 6, 3> B;
    B << Eigen::Matrix3d::Identity(), Skew(row.q);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - n * n.transpose();
    noise += row.weight * row.tilt_variance * B * across * B.transpose();
    gradient += row.weight * row.tilt_variance * B * across * row.offset;
  }
  const MatchSums sums = SumOf(rows_, true);
  EXPECT_TRUE(sums.noise.isApprox(noise, 1e-12));
  EXPECT_TRUE(sums.noise_gradient.isApprox(gradient, 1e-12));
}

// The noise of a normal is the average effect of tilting it.
TEST(MatchSums, NoiseIsTheExpectationOverTiltedNormals) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  std::mt19937 random(8);
  std::normal_distribution<double> tilt(0, 0.02);
  const Eigen::Vector3d q(3, -2, 1);
  const Vector6d exact = PoseJacobian(q, z);
  Matrix6d mean = Matrix6d::Zero();
  constexpr int kDraws = 200'000;
  for (int k = 0; k < kDraws; ++k) {
    const Vector6d jacobian = PoseJacobian(q, z + tilt(random) * x + tilt(random) * y);
    mean += (jacobian * jacobian.transpose() - exact * exact.transpose()) / kDraws;
  }
  MatchRow row;
  row.q = q;
  row.jacobian = exact;
  row.weight = 1;
  row.tilt_variance = 4e-4;
  const Matrix6d noise = SumOf({row}, false).noise;
  EXPECT_LT((noise - mean).norm(), 0.1 * noise.norm());
}

}  // namespace
}  // namespace isthmus::floam
