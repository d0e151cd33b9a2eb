// Odometry of sensors that do not spin, and of scans whose rings nobody knows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/scan/scan_frame.h"
#include "floam/scan/scan_image.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::EndPose;
using testing::FurnishedRoom;
using testing::Loop;
using testing::MakeScan;
using testing::MakeScanWithoutRings;
using testing::Sensor;

constexpr int kPoints = 12000;
constexpr int kScans = 120;

Scan SolidState(int index) {
  return MakeScanWithoutRings(FurnishedRoom(), Loop(1), testing::Raster, kPoints, index);
}
Scan NonRepeating(int index) {
  return MakeScanWithoutRings(FurnishedRoom(), Loop(1), testing::Scattered, kPoints, index);
}
Scan Shuffled(int index) {
  Scan scan = MakeScan(FurnishedRoom(), Loop(1), Sensor(), index);
  scan.has_ring = false;
  std::shuffle(scan.points.begin(), scan.points.end(), std::mt19937(index));
  for (ScanPoint& p : scan.points) p.ring = 0;
  return scan;
}

struct Outcome {
  double rmse_m = 0;
  int not_ok = 0;
  InputText input;
};

Outcome DriveWith(const std::string& sensor, const std::function<Scan(int)>& scan_of,
                  OdometryMode mode = OdometryMode::kContinuous) {
  OdometryOptions options;
  options.mode = mode;
  options.undistort_cloud = false;
  Odometry odometry(*FindSensorModel(sensor), options);
  Outcome outcome;
  Pose T_world_odom;
  for (int k = 0; k < kScans; ++k) {
    const auto result = odometry.Process(scan_of(k));
    if (!result.ok()) {
      ADD_FAILURE() << result.status();
      return outcome;
    }
    outcome.not_ok += result->status == TrackingStatus::kOk ? 0 : 1;
    outcome.input = result->input;
    const Pose truth = EndPose(Loop(1), Sensor(), k);
    if (k == 0) T_world_odom = truth * result->T_odom_sensor.Inverse();
    const Pose error = truth.Inverse() * (T_world_odom * result->T_odom_sensor);
    outcome.rmse_m += error.translation().squaredNorm() / kScans;
  }
  outcome.rmse_m = std::sqrt(outcome.rmse_m);
  return outcome;
}

TEST(AnyLidar, SolidState) {
  const Outcome outcome = DriveWith("solid", SolidState);
  EXPECT_LT(outcome.rmse_m, 0.05);
  EXPECT_LE(outcome.not_ok, 2);
  EXPECT_EQ(outcome.input.rings, "none: surfaces from neighbourhoods");
}

TEST(AnyLidar, NonRepeatingPattern) {
  const Outcome outcome = DriveWith("mid360", NonRepeating);
  EXPECT_LT(outcome.rmse_m, 0.03);
  EXPECT_EQ(outcome.not_ok, 0);
}

TEST(AnyLidar, NonRepeatingPatternOfASensorThatNobodyNamed) {
  EXPECT_LT(DriveWith("auto", NonRepeating).rmse_m, 0.03);
}

TEST(AnyLidar, InTheOtherModes) {
  EXPECT_LT(DriveWith("mid360", NonRepeating, OdometryMode::kFloam).rmse_m, 0.05);
  EXPECT_LT(DriveWith("mid360", NonRepeating, OdometryMode::kAloam).rmse_m, 0.05);
}

TEST(AnyLidar, ShuffledTurnsWithoutRings) {
  EXPECT_LT(DriveWith("unordered", Shuffled).rmse_m, 0.1);
  const Outcome in_rings = DriveWith("auto", Shuffled);  // The elevations show the rings.
  EXPECT_LT(in_rings.rmse_m, 0.03);
  EXPECT_EQ(in_rings.input.rings, "16, by the elevations seen");
}

TEST(AnyLidar, WithoutTimesSlowMotionIsFollowed) {
  const auto scan_of = [](int index) {
    Scan scan = MakeScanWithoutRings(FurnishedRoom(), Loop(0.3), testing::Raster, kPoints, index);
    scan.has_time = false;
    for (ScanPoint& p : scan.points) p.time = 0;
    return scan;
  };
  OdometryOptions options;
  Odometry odometry(*FindSensorModel("solid"), options);
  Pose T_world_odom;
  for (int k = 0; k < kScans; ++k) {
    const auto result = odometry.Process(scan_of(k));
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->input.times, "not given: motion within a scan is not compensated");
    const Pose truth = EndPose(Loop(0.3), Sensor(), k);
    if (k == 0) T_world_odom = truth * result->T_odom_sensor.Inverse();
    const Pose error = truth.Inverse() * (T_world_odom * result->T_odom_sensor);
    EXPECT_LT(error.translation().norm(), 0.1) << k;
  }
}

// A view of 120 degrees says nothing of what lies beside and behind it.
TEST(AnyLidar, WhatIsOutOfViewIsNotSeenThrough) {
  FrameMaker maker(*FindSensorModel("solid"), FeatureOptions());
  ScanFrame frame;
  ASSERT_TRUE(
      maker
          .Make(MakeScanWithoutRings(
                    testing::Room(), [](double) { return Pose(); }, testing::Raster, 20000, 0),
                nullptr, &frame)
          .ok());
  ScanImage image;
  image.Make(frame.scan);
  int through = 0, onto = 0;
  for (double azimuth = -3.1; azimuth < 3.1; azimuth += 0.02) {
    const Eigen::Vector3f ahead(static_cast<float>(std::cos(azimuth)),
                                static_cast<float>(std::sin(azimuth)), 0.05F);
    const auto range = static_cast<float>(
        testing::Room().Cast(Eigen::Vector3d::Zero(), ahead.normalized().cast<double>()));
    const bool in_view = std::abs(azimuth) < 1.03;
    const ScanImage::Sight near = image.SightOf(0.5F * range * ahead.normalized());
    const ScanImage::Sight there = image.SightOf(range * ahead.normalized());
    if (!in_view && std::abs(azimuth) > 1.07) {
      EXPECT_EQ(near, ScanImage::Sight::kUnknown) << azimuth;
      EXPECT_EQ(there, ScanImage::Sight::kUnknown) << azimuth;
    }
    through += near == ScanImage::Sight::kThrough ? 1 : 0;
    onto += there == ScanImage::Sight::kOnto ? 1 : 0;
    EXPECT_NE(there, ScanImage::Sight::kThrough) << azimuth;
  }
  EXPECT_GT(through, 90);
  EXPECT_GT(onto, 90);
}

}  // namespace
}  // namespace isthmus::floam
