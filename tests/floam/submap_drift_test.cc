// Submaps' estimates of the odometry's errors, compared with drives whose errors are drawn at
// random.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

#include "floam/submap_builder.h"

namespace isthmus::floam {
namespace {

Matrix6d Diagonal(double position, double rotation) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(rotation);
  return sigma.cwiseAbs2().asDiagonal();
}

Matrix6d Unobserved(const Eigen::Vector3d& direction, double sigma) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() = sigma * sigma * direction * direction.transpose();
  return covariance;
}

using Drive = std::vector<OdometryResult>;

// Ten scans a second, one metre and `turn` apart.
Drive MakeDrive(int scans, double turn) {
  Drive drive;
  Pose T_odom_sensor = Pose::FromXyzRpy(5, -3, 1, 0.1, 0.05, 2);
  for (int k = 0; k < scans; ++k) {
    OdometryResult result;
    result.sequence = k;
    result.stamp_ns = int64_t{k} * 100'000'000;
    result.T_odom_sensor = T_odom_sensor;
    result.matched_covariance = Diagonal(0.01, 0.004);
    drive.push_back(result);
    T_odom_sensor = T_odom_sensor * Pose::FromXyzRpy(1, 0, 0, 0, 0, turn);
  }
  return drive;
}

struct Cut {
  std::shared_ptr<const Submap> before, submap;
};

// The first two submaps.
Cut CutDrive(const Drive& drive) {
  SubmapBuilder builder(SessionId("alice-1"), RobotId("alice"), {});
  std::vector<std::shared_ptr<const Submap>> submaps;
  for (const OdometryResult& result : drive) {
    if (auto submap = builder.Add(result)) submaps.push_back(submap);
  }
  if (auto submap = builder.Finish()) submaps.push_back(submap);
  return {submaps.at(0), submaps.at(1)};
}

// The covariance of the error of the second submap's pose, as seen from the first: its first scan
// and the first one's are placed anew at random, and so is each step between.
Matrix6d MonteCarlo(const Drive& drive, const Cut& cut) {
  constexpr int kTrials = 6000;
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  const auto draw = [&](const Matrix6d& covariance) {
    Vector6d noise;
    for (double& value : noise) value = gauss(random);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(covariance);
    return Exp(solver.eigenvectors() *
               (solver.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseProduct(noise)));
  };
  const size_t first = cut.before->first_sequence, last = cut.submap->first_sequence;
  const Pose T_before_this = cut.before->T_odom_submap.Inverse() * cut.submap->T_odom_submap;
  Matrix6d sum = Matrix6d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    Pose truth = draw(drive[first].matched_covariance);
    for (size_t k = first + 1; k <= last; ++k) {
      const Pose step = drive[k - 1].T_odom_sensor.Inverse() * drive[k].T_odom_sensor;
      truth = truth * step * draw(drive[k].unobserved_covariance);
    }
    truth = truth * draw(drive[last].matched_covariance);
    const Vector6d twist = Log(truth * T_before_this.Inverse());
    sum += twist * twist.transpose();
  }
  return sum / kTrials;
}

// Each entry to a share of the two standard deviations that it is of.
void ExpectNear(const Matrix6d& covariance, const Matrix6d& expected) {
  const Vector6d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d difference = scale.asDiagonal() * (covariance - expected) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.08) << covariance << "\n\n" << expected;
}

TEST(SubmapDrift, OfTheFirstIsNotSaid) {
  const Cut cut = CutDrive(MakeDrive(40, 0));
  EXPECT_TRUE(cut.before->drift_covariance.isZero(0));
  EXPECT_FALSE(cut.submap->drift_covariance.isZero(0));
  EXPECT_EQ(cut.submap->drift_covariance, cut.submap->drift_covariance.transpose());
}

TEST(SubmapDrift, OfAStraightDrive) {
  const Drive drive = MakeDrive(40, 0);
  const Cut cut = CutDrive(drive);
  ExpectNear(cut.submap->drift_covariance, MonteCarlo(drive, cut));
  // Sideways a turned end is off by the length of the way times the angle, seen from its begin.
  const double length_m =
      (cut.submap->T_odom_submap.translation() - cut.before->T_odom_submap.translation()).norm();
  EXPECT_NEAR(cut.submap->drift_covariance(1, 1), 2e-4 + std::pow(0.004 * length_m, 2), 1e-9);
  EXPECT_NEAR(cut.submap->drift_covariance(0, 0), 2e-4, 1e-9);
}

TEST(SubmapDrift, OfATurn) {
  Drive drive = MakeDrive(40, 0.12);
  for (OdometryResult& result : drive) {
    result.unobserved_covariance = Diagonal(0.005, 0.002) + Unobserved({0.6, 0.8, 0}, 0.03);
  }
  const Cut cut = CutDrive(drive);
  ExpectNear(cut.submap->drift_covariance, MonteCarlo(drive, cut));
}

// Round a corner, then blind along the corridor that lies to the left of how it began.
TEST(SubmapDrift, IsLargeAlongWhatWasNotObserved) {
  Drive drive = MakeDrive(5, std::numbers::pi / 8);
  Drive corridor = MakeDrive(20, 0);
  const Pose T_odom_corner = drive.back().T_odom_sensor * corridor.front().T_odom_sensor.Inverse();
  for (size_t k = 1; k < corridor.size(); ++k) {
    OdometryResult result = corridor[k];
    result.sequence = drive.size();
    result.T_odom_sensor = T_odom_corner * result.T_odom_sensor;
    result.unobserved_covariance = Unobserved(Eigen::Vector3d::UnitX(), 0.5);
    drive.push_back(result);
  }
  const Cut cut = CutDrive(drive);
  const auto blind = static_cast<double>(cut.submap->first_sequence - 4);
  ASSERT_GT(blind, 5);
  const Matrix6d& covariance = cut.submap->drift_covariance;
  EXPECT_NEAR(covariance(1, 1), 0.25 * blind, 0.01 * blind);
  EXPECT_LT(covariance(0, 0), 0.02);
  EXPECT_LT(covariance(2, 2), 0.02);
}

// The submap ends there, and the next one tells.
TEST(SubmapDrift, LostScansCount) {
  Drive drive = MakeDrive(12, 0.05);
  for (const size_t k : {6, 7}) {
    drive[k].status = TrackingStatus::kLost;
    drive[k].matched_covariance = Matrix6d::Zero();
    drive[k].unobserved_covariance = Diagonal(1, 0.1);
  }
  const Cut cut = CutDrive(drive);
  ASSERT_EQ(cut.before->last_sequence, 5u);
  ASSERT_EQ(cut.submap->first_sequence, 8u);
  ExpectNear(cut.submap->drift_covariance, MonteCarlo(drive, cut));
  EXPECT_GT(cut.submap->drift_covariance.diagonal().head<3>().minCoeff(), 2);
}

}  // namespace
}  // namespace isthmus::floam
