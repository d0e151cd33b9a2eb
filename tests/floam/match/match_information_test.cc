#include "floam/match/match_information.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>
#include <vector>

namespace isthmus::floam {
namespace {

struct Plane {
  Eigen::Vector3d q, normal;
  double residual = 0;
};

// Matches at random places to planes of these normals.
std::vector<Plane> Planes(const std::vector<Eigen::Vector3d>& normals, int each) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-8, 8);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<Plane> planes;
  for (const Eigen::Vector3d& normal : normals) {
    for (int k = 0; k < each; ++k) {
      planes.push_back(
          {{uniform(random), uniform(random), uniform(random)}, normal, noise(random)});
    }
  }
  return planes;
}

constexpr double kWeight = 2500;

using Rows = std::vector<MatchRow>;

Rows RowsOf(const std::vector<Plane>& planes, double tilt_variance = 0,
            const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  Rows rows;
  for (const Plane& plane : planes) {
    rows.push_back({PoseJacobian(plane.q, plane.normal), kWeight, plane.residual, 0, plane.q,
                    offset, tilt_variance});
  }
  return rows;
}

JointEstimate SolveOf(const Rows& rows, const Vector6d& offset) {
  MatchSums sums = SumOf(rows, false);
  sums.information.bottomRightCorner<6, 6>().setIdentity();
  return Solve(sums, rows, 0.01 * Matrix6d::Identity(), offset);
}

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(),
                      kZ = Eigen::Vector3d::UnitZ();

TEST(MatchInformation, ManyGoodMatchesAndThePriorAreJoinedAsInformation) {
  const Rows rows = RowsOf(Planes({kX, kY, kZ}, 300));
  const MatchSums sums = SumOf(rows, false);
  const Vector6d offset = 0.05 * Vector6d::Ones();
  const JointEstimate estimate = SolveOf(rows, offset);
  const Matrix6d H = sums.information.topLeftCorner<6, 6>();
  const Matrix6d prior = 100 * Matrix6d::Identity();
  const Vector6d g = sums.gradient.head<6>();
  const Vector6d expected = -(H + prior).inverse() * (g + prior * offset);
  EXPECT_LT((estimate.step.head<6>() - expected).norm(), 1e-6);
  EXPECT_TRUE((estimate.covariance.topLeftCorner<6, 6>()).isApprox((H + prior).inverse(), 1e-6));
  EXPECT_TRUE(estimate.match_information.isApprox(H, 1e-6));
}

TEST(MatchInformation, WhatIsNotObservedStaysAsThePriorHasIt) {
  const Rows rows = RowsOf(Planes({kY, kZ}, 300));
  const Vector6d offset = (Vector6d() << 0.3, 0.1, 0, 0, 0, 0).finished();
  const JointEstimate estimate = SolveOf(rows, offset);
  EXPECT_NEAR(estimate.step[0], -0.3, 1e-6);
  EXPECT_NEAR(estimate.step[1], 0, 0.01);
  EXPECT_NEAR(estimate.covariance(0, 0), 0.01, 1e-6);
}

// Normals that are off by chance look as if they held what no plane holds.
TEST(MatchInformation, NoiseOfNormalsIsNoInformation) {
  std::mt19937 random(5);
  std::normal_distribution<double> tilt(0, 0.03);
  std::vector<Plane> planes = Planes({kY, kZ}, 1000);
  for (Plane& plane : planes) {
    plane.normal += tilt(random) * kX;
    plane.normal.normalize();
  }
  const JointEstimate believed = SolveOf(RowsOf(planes), Vector6d::Zero());
  const JointEstimate honest = SolveOf(RowsOf(planes, 9e-4), Vector6d::Zero());
  const auto information = [](const JointEstimate& e) { return 1 / e.covariance(0, 0) - 100; };
  EXPECT_GT(information(believed), 1300);
  EXPECT_LT(information(honest), 0.2 * information(believed));
  // And nobody is told so, for none of the planes lies across.
  EXPECT_LT(believed.match_information(0, 0), 0.01 * information(believed));
}

// As much information of few planes that do lie across is said to be known.
TEST(MatchInformation, PlainMatchesAreSaidToTell) {
  std::vector<Plane> planes = Planes({kY, kZ}, 1000);
  for (const Plane& plane : Planes({kX}, 12)) planes.push_back(plane);
  const JointEstimate estimate = SolveOf(RowsOf(planes), Vector6d::Zero());
  EXPECT_GT(estimate.match_information(0, 0), 0.2 * 12 * kWeight);
}

// The rings of a slow sensor lie where they lay before: noise would have it stand still.
TEST(MatchInformation, NoiseDoesNotDrawTheEstimate) {
  const double tilt = 0.03;
  std::vector<Plane> planes = Planes({kY, kZ}, 1000);
  std::mt19937 random(6);
  std::normal_distribution<double> normal(0, tilt);
  const Eigen::Vector3d offset(0.12, 0, 0);  // From the middle of the map's points, moving.
  for (Plane& plane : planes) {
    plane.normal = (plane.normal + normal(random) * kX).normalized();
    plane.residual += plane.normal.dot(offset);
  }
  const double drawn = SolveOf(RowsOf(planes), Vector6d::Zero()).step[0];
  const double honest = SolveOf(RowsOf(planes, tilt * tilt, offset), Vector6d::Zero()).step[0];
  EXPECT_LT(drawn, -0.1);
  EXPECT_NEAR(honest, 0, 0.03);
}

TEST(MatchInformation, AFewMatchesDecideNothing) {
  std::vector<Plane> planes = Planes({kY, kZ}, 300);
  for (int k = 0; k < 3; ++k) planes.push_back({{30, 0.1 * k, 0}, kX, 0.2});
  const JointEstimate estimate = SolveOf(RowsOf(planes), Vector6d::Zero());
  EXPECT_NEAR(estimate.step[0], 0, 1e-3);
  for (int k = 0; k < 97; ++k) planes.push_back({{30, 0.02 * k, 0}, kX, 0.2});
  EXPECT_LT(SolveOf(RowsOf(planes), Vector6d::Zero()).step[0], -0.15);
}

}  // namespace
}  // namespace isthmus::floam
