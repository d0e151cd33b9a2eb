#include "floam/match/scan_to_scan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "floam/match/match_sums.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::EndPose;
using testing::FurnishedRoom;
using testing::Loop;
using testing::MakeScan;
using testing::Motion;
using testing::Room;
using testing::Sensor;

constexpr double kPeriodS = 0.1;
// Tolerances of the motion in one period. Rings on walls tell least about height.
constexpr double kToleranceM = 0.006;
constexpr double kHeightToleranceM = 0.025;
constexpr double kToleranceRad = 0.004;

Features FeaturesOf(const Motion& motion, int index, double noise_m = 0.01) {
  static const Room room = FurnishedRoom();
  Sensor sensor;
  sensor.noise_m = noise_m;
  RingScan scan;
  EXPECT_TRUE(
      RingSorter()
          .Sort(MakeScan(room, motion, sensor, index), *FindSensorModel("vlp16"), kPeriodS, &scan)
          .ok());
  Features features;
  FeatureExtractor(FeatureOptions()).Extract(scan, &features);
  return features;
}

Pose SomePlace() { return Pose::FromXyzRpy(-1.7, 1.4, 0.05, 0.01, -0.02, 0.8); }

// A scan taken in an instant.
Features Snapshot(const Pose& T_world_sensor, int index, double noise_m = 0.01) {
  Features features = FeaturesOf([&](double) { return T_world_sensor; }, index, noise_m);
  for (auto* points : {&features.edges, &features.surfaces, &features.map_surfaces}) {
    for (TimedPoint& p : *points) p.time = 0;
  }
  return features;
}

Pose FoundBetween(const Pose& from, const Pose& to, double noise_m = 0.01) {
  ScanToScan matcher;
  matcher.SetPrevious(Snapshot(from, 0, noise_m));
  const ScanToScanResult result =
      matcher.Match(Snapshot(to, 1, noise_m), Vector6d::Zero(), kPeriodS);
  EXPECT_GT(result.used, result.features / 2);
  return Exp(kPeriodS * result.twist);
}

void ExpectNear(const Pose& expected, const Pose& actual, double by = 1) {
  const Pose error = expected.Inverse() * actual;
  EXPECT_LT(error.translation().head<2>().norm(), by * kToleranceM);
  EXPECT_LT(std::abs(error.translation().z()), by * kHeightToleranceM);
  EXPECT_LT(RotationAngle(error), by * kToleranceRad);
}

// The derivative of n . Exp(s xi) p by T -> Exp(d) T, T = Exp(xi): exact at rest, and to first
// order in the motion.
TEST(ScanToScanJacobian, AgreesWithNumericalDerivatives) {
  const Eigen::Vector3d p(4, -2, 1), n = Eigen::Vector3d(1, 2, 3).normalized();
  for (const double scale : {0.0, 1.0}) {
    const Vector6d xi = scale * (Vector6d() << 0.3, 0.05, -0.02, 0.01, -0.02, 0.09).finished();
    for (const double share : {0.1, 0.6, 1.0, 1.4}) {
      const Vector6d analytic = share * PoseJacobian(Exp(share * xi) * p, n);
      for (int k = 0; k < 6; ++k) {
        const double h = 1e-6;
        const auto distance = [&](double step) {
          const Vector6d moved = Log(Exp(step * Vector6d::Unit(k)) * Exp(xi));
          return n.dot(Exp(share * moved) * p);
        };
        const double numeric = (distance(h) - distance(-h)) / (2 * h);
        EXPECT_NEAR(analytic[k], numeric, 1e-8 + xi.norm() * analytic.norm()) << share << " " << k;
      }
    }
  }
}

TEST(ScanToScan, FindsMotionsForwardAndInverse) {
  for (int axis = 0; axis < 6; ++axis) {
    SCOPED_TRACE(axis);
    const Pose motion = Exp((axis < 3 ? 0.1 : 0.05) * Vector6d::Unit(axis));
    const Pose forward = FoundBetween(SomePlace(), SomePlace() * motion);
    const Pose inverse = FoundBetween(SomePlace() * motion, SomePlace());
    ExpectNear(motion, forward);
    ExpectNear(motion.Inverse(), inverse);
    ExpectNear(Pose(), forward * inverse);
  }
}

TEST(ScanToScan, FindsTheSameMotionFromOtherPlaces) {
  const Pose motion = Pose::FromXyzRpy(0.12, -0.03, 0, 0, 0, 0.06);
  for (const Pose& shift :
       {Pose::FromXyzRpy(0.7, 0.4, 0, 0, 0, 0), Pose::FromXyzRpy(3, 0.9, 0.2, 0, 0, 2)}) {
    ExpectNear(motion, FoundBetween(shift * SomePlace(), shift * SomePlace() * motion));
  }
}

TEST(ScanToScan, ToleratesNoise) {
  const Pose motion = Pose::FromXyzRpy(0.12, -0.03, 0, 0, 0, 0.06);
  ExpectNear(motion, FoundBetween(SomePlace(), SomePlace() * motion, 0.03), 2);
}

TEST(ScanToScan, FindsTheMotionOfMovingScansFromRest) {
  const Vector6d twist = (Vector6d() << 1.4, 0.1, 0, 0, 0, 0.9).finished();
  const Motion motion = [&](double time_s) { return SomePlace() * Exp((time_s - 0.1) * twist); };
  ScanToScan matcher;
  matcher.SetPrevious(FeaturesOf(motion, 0));
  for (int k = 1; k < 6; ++k) {
    const Features features = FeaturesOf(motion, k);
    const Vector6d found = matcher.Match(features, Vector6d::Zero(), kPeriodS).twist;
    ExpectNear(Exp(kPeriodS * twist), Exp(kPeriodS * found));
    matcher.SetPrevious(features);
  }
}

TEST(ScanToScan, FindsTheMotionOverADroppedScan) {
  const Vector6d twist = (Vector6d() << 1.4, 0.1, 0, 0, 0, 0.9).finished();
  const Motion motion = [&](double time_s) { return SomePlace() * Exp((time_s - 0.1) * twist); };
  ScanToScan matcher;
  matcher.SetPrevious(FeaturesOf(motion, 0));
  const Vector6d found = matcher.Match(FeaturesOf(motion, 2), 0.8 * twist, 2 * kPeriodS).twist;
  ExpectNear(Exp(kPeriodS * twist), Exp(kPeriodS * found));
}

TEST(ScanToScan, KeepsThePredictionWhereThereIsNothingToMatch) {
  const Features features = Snapshot(SomePlace(), 0);
  ScanToScan matcher;
  const Vector6d twist = (Vector6d() << 1, 0, 0, 0, 0, 0.3).finished();
  const ScanPose prediction{SomePlace(), twist, 0};
  const auto expect_unchanged = [&](const Features& scan) {
    const ScanPose guess = matcher.Guess(scan, prediction, kPeriodS);
    EXPECT_EQ(guess.T_odom_sensor.Matrix(), prediction.T_odom_sensor.Matrix());
    EXPECT_EQ(guess.twist, prediction.twist);
  };
  EXPECT_EQ(matcher.Match(features, twist, kPeriodS).used, 0);
  expect_unchanged(features);  // No scan before it.
  matcher.SetPrevious(features);
  expect_unchanged(Features());  // A blank one.
  matcher.SetPrevious(Features());
  expect_unchanged(features);
}

TEST(ScanToScan, CorrectsThePrediction) {
  const Vector6d twist = (Vector6d() << 1.4, 0.1, 0, 0, 0, 0.9).finished();
  const Motion motion = [&](double time_s) { return SomePlace() * Exp((time_s - 0.1) * twist); };
  ScanToScan matcher;
  matcher.SetPrevious(FeaturesOf(motion, 0));
  const ScanPose standing{SomePlace(), Vector6d::Zero(), 0};
  const ScanPose guess = matcher.Guess(FeaturesOf(motion, 1), standing, kPeriodS);
  ExpectNear(motion(0.2), guess.T_odom_sensor);
}

// The whole of it: scan to scan, then scan to map.
TEST(Aloam, FollowsALoop) {
  OdometryOptions options;
  options.mode = OdometryMode::kAloam;
  Odometry odometry(*FindSensorModel("vlp16"), options);
  const Room room = FurnishedRoom();
  const Sensor sensor;
  const Motion motion = Loop(1.2);
  const Pose T_world_odom = EndPose(motion, sensor, 0);
  double sum = 0;
  Pose error;
  for (int k = 0; k < 200; ++k) {  // Once around, heading through 360 degrees.
    const auto result = odometry.Process(MakeScan(room, motion, sensor, k));
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
    error = EndPose(motion, sensor, k).Inverse() * (T_world_odom * result->T_odom_sensor);
    sum += error.translation().squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum / 200), 0.02);
  EXPECT_LT(RotationAngle(error), 0.01);
}

}  // namespace
}  // namespace isthmus::floam
