#include "floam/odometry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/paper.h"
#include "floam/match/feature_map.h"
#include "floam/odometry_options.h"
#include "tests/floam/odometry_drive.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::Drive;
using testing::EndPose;
using testing::ExpectTrackedAgain;
using testing::Loop;
using testing::MakeScan;
using testing::Motion;
using testing::Room;
using testing::Sensor;
using testing::Vlp16;
using testing::WithMode;

class OdometryModes : public ::testing::TestWithParam<OdometryMode> {};

INSTANTIATE_TEST_SUITE_P(Both, OdometryModes,
                         ::testing::Values(OdometryMode::kFloam, OdometryMode::kContinuous),
                         [](const auto& param) {
                           return param.param == OdometryMode::kFloam ? "Floam" : "Continuous";
                         });

TEST(OdometryModeNames, SayWhatThisBuildHas) {
  EXPECT_EQ(OdometryModeNames().size(), kHasPaper ? 3u : 2u);
  EXPECT_EQ(*ParseOdometryMode("floam"), OdometryMode::kFloam);
  const auto aloam = ParseOdometryMode("aloam");
  EXPECT_EQ(aloam.ok(), kHasPaper);
  if (!aloam.ok()) {
    EXPECT_THAT(std::string(aloam.status().message()), ::testing::HasSubstr("ISTHMUS_PAPER"));
  }
  EXPECT_THAT(std::string(ParseOdometryMode("loam").status().message()),
              ::testing::StartsWith("unknown"));
}

TEST_P(OdometryModes, FollowsALoop) {
  Drive drive(Loop(1.2), WithMode(GetParam()));
  for (int k = 0; k < 200; ++k) {  // Once around, heading through 360 degrees.
    const auto result = drive.Step(k);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
    EXPECT_EQ(result->sequence, static_cast<uint64_t>(k) + 1);
  }
  EXPECT_LT(drive.Rmse(), 0.02);
  EXPECT_LT(RotationAngle(drive.error()), 0.01);
}

// Every point where it was at the END of the scan, as other programs give it: `times` of 0.
Scan Compensated(Scan scan, const Motion& motion, double end_s) {
  const Pose T_end_world = motion(end_s).Inverse();
  for (ScanPoint& p : scan.points) {
    const Eigen::Vector3f at =
        (T_end_world * (motion(end_s + p.time) * Eigen::Vector3d(p.x, p.y, p.z))).cast<float>();
    p.x = at.x();
    p.y = at.y();
    p.z = at.z();
    p.time = 0;
  }
  return scan;
}

TEST_P(OdometryModes, FollowsCompensatedScansAsWellAsOthers) {
  const Motion motion = Loop(1.2);
  Drive plain(motion, WithMode(GetParam())), compensated(motion, WithMode(GetParam())),
      twice(motion, WithMode(GetParam()));
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(plain.Step(k).ok());
    Scan scan = Compensated(MakeScan(plain.room(), motion, plain.sensor(), k), motion,
                            (k + 1) * plain.sensor().period_s);
    const auto result = compensated.Process(scan, k);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
    EXPECT_EQ(result->input.times, "given");
    scan.has_time = false;  // And once more, by times of azimuth.
    ASSERT_TRUE(twice.Process(scan, k).ok());
  }
  EXPECT_LT(compensated.Rmse(), 1.1 * plain.Rmse());
  EXPECT_GT(twice.Rmse(), 1.5 * plain.Rmse());
}

TEST_P(OdometryModes, StandsStill) {
  Drive drive([](double) { return Pose::FromXyzRpy(1, 3, 0, 0, 0, 0.4); }, WithMode(GetParam()));
  for (int k = 0; k < 150; ++k) {
    ASSERT_TRUE(drive.Step(k).ok());
    EXPECT_LT(drive.error().translation().norm(), 0.01) << k;
  }
}

TEST_P(OdometryModes, SpinsInPlace) {
  const auto spin = [](double time_s) {  // Up to 60 degrees per second, more than once around.
    const double moving = std::max(0.0, time_s - 0.4);
    const double angle = moving < 1 ? 0.5 * moving * moving : moving - 0.5;
    return Pose::FromXyzRpy(2, 2.5, 0, 0, 0, 1.05 * angle);
  };
  Drive drive(spin, WithMode(GetParam()));
  for (int k = 0; k < 85; ++k) ASSERT_EQ(drive.Step(k)->status, TrackingStatus::kOk) << k;
  EXPECT_LT(drive.Rmse(), 0.02);
  EXPECT_LT(RotationAngle(drive.error()), 0.01);
}

TEST_P(OdometryModes, StartsAtSpeed) {
  const Motion loop = Loop(1.5);
  Drive drive([&](double time_s) { return loop(time_s + 4); }, WithMode(GetParam()));
  for (int k = 0; k < 60; ++k) ASSERT_EQ(drive.Step(k)->status, TrackingStatus::kOk) << k;
  EXPECT_LT(drive.Rmse(), 0.03);
}

// Walls at round coordinates without any noise, as in a drawing; `index` counts from the start.
Scan ScanOfDrawnRoom(const Motion& motion, bool with_time, int index) {
  Room room;
  room.walls = {{-3, -6, -1.2}, {22, 7, 3}};
  room.boxes = {{{3, 2, -1.2}, {3.7, 2.9, 3}},
                {{8, -4, -1.2}, {9, -3.2, 3}},
                {{13, 3, -1.2}, {14.5, 3.6, 3}},
                {{17, -2.6, -1.2}, {17.4, -1.4, 3}}};
  Sensor sensor;
  sensor.noise_m = 0;
  Scan scan = MakeScan(room, motion, sensor, index);
  scan.has_time = with_time;
  if (!with_time) {
    for (ScanPoint& p : scan.points) p.time = 0;
  }
  return scan;
}

TEST_P(OdometryModes, StartsUnderWayAmongWallsAtRoundCoordinates) {
  for (const bool with_time : {true, false}) {
    for (const double speed : {0.0, 1.0, 2.0, 4.0}) {
      for (const double yaw_rate : {0.0, 1.05}) {
        SCOPED_TRACE(::testing::Message() << with_time << " " << speed << " " << yaw_rate);
        const Vector6d twist = (Vector6d() << speed, 0, 0, 0, 0, yaw_rate).finished();
        // The END of the first scan is where the room's coordinates begin.
        const Motion motion = [&](double time_s) { return Exp((time_s - 0.1) * twist); };
        Odometry odometry(Vlp16(), WithMode(GetParam()));
        for (int k = 0; k < 10; ++k) {
          const auto result = odometry.Process(ScanOfDrawnRoom(motion, with_time, k));
          ASSERT_TRUE(result.ok());
          EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
          const Pose error = EndPose(motion, Sensor(), k).Inverse() * result->T_odom_sensor;
          EXPECT_LT(error.translation().norm(), 0.03) << k;
          EXPECT_LT(RotationAngle(error), 0.01) << k;
        }
      }
    }
  }
}

TEST(Odometry, FirstPoseIsTheOriginAndCovarianceIsPositive) {
  Drive drive(Loop(1), OdometryOptions());
  const auto first = drive.Step(0);
  ASSERT_TRUE(first.ok());
  EXPECT_LT(Log(first->T_odom_sensor).norm(), 1e-9);
  EXPECT_EQ(first->status, TrackingStatus::kOk);
  const auto second = drive.Step(1);
  ASSERT_TRUE(second.ok());
  const Matrix6d& covariance = second->covariance;
  EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-6));
  EXPECT_GT(covariance.ldlt().vectorD().minCoeff(), 0);
  // Everything is seen of a room.
  EXPECT_EQ(second->matched_covariance, covariance);
  EXPECT_TRUE(second->unobserved_covariance.isZero(0));
}

TEST(Odometry, UndistortsTheWholeScanToItsEnd) {
  const Motion motion = Loop(1.2);
  Drive drive(motion, OdometryOptions());
  absl::StatusOr<OdometryResult> result;
  for (int k = 0; k < 40; ++k) result = drive.Step(k);
  ASSERT_TRUE(result.ok());
  const Scan scan = MakeScan(drive.room(), motion, drive.sensor(), 39);
  ASSERT_EQ(result->undistorted.size(), scan.points.size());
  // Each point lies on the surface that a ray from where the sensor was at the END would hit.
  const Pose T_world_end = EndPose(motion, drive.sensor(), 39);
  double fixed = 0, raw = 0;
  const auto off_surface = [&](const Eigen::Vector3d& p) {
    const double range =
        drive.room().Cast(T_world_end.translation(), T_world_end.rotation() * p.normalized());
    return std::min(0.3, std::abs(range - p.norm()));
  };
  for (const Point& p : result->undistorted) fixed += off_surface(p.Position().cast<double>());
  for (const ScanPoint& p : scan.points) raw += off_surface(Eigen::Vector3d(p.x, p.y, p.z));
  const auto count = static_cast<double>(scan.points.size());
  EXPECT_LT(fixed / count, 0.02);
  EXPECT_GT(raw / count, 0.03);
}

TEST(Odometry, WorksWithoutRingsAndTimes) {
  const Motion motion = Loop(1.2);
  Drive drive(motion, WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 80; ++k) {
    Scan scan = MakeScan(drive.room(), motion, drive.sensor(), k);
    scan.has_ring = scan.has_time = false;
    for (ScanPoint& p : scan.points) p.ring = 0, p.time = 0;
    ASSERT_TRUE(drive.Process(scan, k).ok());
  }
  EXPECT_LT(drive.Rmse(), 0.02);
}

TEST(Odometry, BlankScansAreRefusedAndItGoesOnAfterThem) {
  Drive drive(Loop(1.2), WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(drive.Step(k).ok());
  for (int k = 60; k < 75; ++k) {
    Scan blank;
    blank.sequence = k + 1;
    blank.end_stamp_ns = 1'000'000'000 + (k + 1) * 100'000'000LL;
    EXPECT_EQ(drive.odometry().Process(blank).status().code(), absl::StatusCode::kInvalidArgument);
  }
  ExpectTrackedAgain(&drive, 75, 110);
}

// Many scans from one place show no more than the first: single rings, of which few make planes.
TEST(FeatureMap, IsYoungUntilTheSensorHasMoved) {
  const OdometryOptions options;
  FeatureMap map(options);
  const Features nothing;
  const auto stand_at = [&](double x) {
    ScanPose pose;
    pose.T_odom_sensor = Pose::FromXyzRpy(x, 0, 0, 0, 0, 0);
    map.Update(nothing, pose, 0.1);
  };
  for (int k = 0; k < 3 * options.map_first_scans; ++k) {
    EXPECT_TRUE(map.IsYoung()) << k;
    EXPECT_EQ(map.IsNew(), k < options.map_first_scans) << k;
    stand_at(5);
  }
  stand_at(5 + 0.6 * options.map_young_distance_m);
  stand_at(5 - 0.6 * options.map_young_distance_m);
  EXPECT_TRUE(map.IsYoung());
  stand_at(5 + 1.1 * options.map_young_distance_m);
  EXPECT_FALSE(map.IsYoung());
  stand_at(5);
  EXPECT_FALSE(map.IsYoung());
}

TEST(Odometry, BadScansLeaveTheStateAsItWas) {
  const Motion motion = Loop(1.2);
  Drive undisturbed(motion, WithMode(OdometryMode::kContinuous));
  Drive disturbed(motion, WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 20; ++k) {
    Scan bad = MakeScan(disturbed.room(), motion, disturbed.sensor(), k);
    for (const auto& damage : std::vector<std::function<void(Scan*)>>{
             [](Scan* scan) { scan->points.clear(); },
             [](Scan* scan) { scan->points[9].z = std::numeric_limits<float>::quiet_NaN(); },
             [](Scan* scan) {
               for (ScanPoint& p : scan->points) p.x = p.y = p.z = 1;
             },
             [](Scan* scan) { scan->end_stamp_ns = 5; }}) {
      Scan damaged = bad;
      damage(&damaged);
      if (k == 0 && !damaged.points.empty() && damaged.end_stamp_ns == 5) continue;
      EXPECT_EQ(disturbed.odometry().Process(damaged).status().code(),
                absl::StatusCode::kInvalidArgument);
    }
    const auto expected = undisturbed.Step(k), actual = disturbed.Step(k);
    ASSERT_TRUE(expected.ok() && actual.ok());
    EXPECT_EQ(expected->T_odom_sensor.Matrix(), actual->T_odom_sensor.Matrix());
  }
}

TEST(Odometry, TakesScansInOrderOfTimeOnly) {
  Drive drive(Loop(1), WithMode(OdometryMode::kContinuous));
  ASSERT_TRUE(drive.Step(3).ok());
  EXPECT_EQ(drive.Step(3).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(drive.Step(1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(drive.Step(4).ok());
}

}  // namespace
}  // namespace isthmus::floam
