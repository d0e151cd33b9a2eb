// Robots that were kidnapped, or saw nothing for a while.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "floam/odometry.h"
#include "tests/floam/odometry_drive.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::Drive;
using testing::ExpectTrackedAgain;
using testing::FurnishedRoom;
using testing::Loop;
using testing::MakeScan;
using testing::Motion;
using testing::Room;
using testing::Sensor;
using testing::WithMode;

TEST(Odometry, SaysSoWhenItIsLostAndFindsItselfAgain) {
  const Motion motion = Loop(1.2);
  Drive drive(motion, WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(drive.Step(k).ok());
  // Another place altogether: carried away, or something right before the sensor.
  Room elsewhere;
  elsewhere.walls = {{-1.9, -0.8, -0.5}, {0.7, 2.4, 0.6}};
  Matrix6d unobserved = Matrix6d::Zero();
  for (int k = 60; k < 70; ++k) {
    Scan scan = MakeScan(
        elsewhere, [](double) { return Pose(); }, drive.sensor(), k);
    const auto result = drive.odometry().Process(scan);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->status, TrackingStatus::kLost) << k;
    EXPECT_GT(result->covariance(0, 0), 1);
    unobserved += result->unobserved_covariance;
  }
  EXPECT_NEAR(unobserved(0, 0), 1.0 / 3, 1e-6);  // White acceleration over one second.
  ExpectTrackedAgain(&drive, 70, 100);
}

// Rain, or rough walls after smooth ones: a scan that lies on the map less well than those before
// is where the one before it says.
TEST(Odometry, IsNotLostWhereScansFitLessWellThanUsual) {
  for (const double noise_m : {0.055, 0.07}) {
    const Motion motion = Loop(1.2);
    Drive drive(motion, WithMode(OdometryMode::kContinuous));
    for (int k = 0; k < 120; ++k) {
      Sensor sensor = drive.sensor();
      if (k >= 60) sensor.noise_m = noise_m;
      const auto result = drive.Process(MakeScan(drive.room(), motion, sensor, k), k);
      ASSERT_TRUE(result.ok());
      ASSERT_EQ(result->status, TrackingStatus::kOk) << noise_m << " " << k;
      ASSERT_LT(drive.error().translation().norm(), 0.05) << noise_m << " " << k;
    }
  }
}

// Dust shows nothing to begin a segment with, and so nothing that the robot could be looked for by.
TEST(Odometry, IsLookedForWhereItWasOnceTheDustHasSettled) {
  Drive drive(Loop(1.2), WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(drive.Step(k).ok());
  std::mt19937 random(3);
  std::uniform_real_distribution<float> range(0.6F, 3);
  for (int k = 60; k < 90; ++k) {
    Scan scan = MakeScan(
        drive.room(), [](double) { return Pose(); }, drive.sensor(), k);
    for (ScanPoint& p : scan.points) {
      const float nearer = range(random) / std::hypot(p.x, p.y, p.z);
      p.x *= nearer, p.y *= nearer, p.z *= nearer;
    }
    const auto result = drive.odometry().Process(scan);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->status, TrackingStatus::kLost) << k;
  }
  // It stood still meanwhile.
  for (int k = 90; k < 110; ++k) {
    Scan scan = MakeScan(
        drive.room(), [&](double time_s) { return Loop(1.2)(time_s - 3); }, drive.sensor(), k);
    const auto result = drive.odometry().Process(scan);
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->segment, 1u) << k;
    if (k > 100) {
      EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
    }
  }
}

// Carried to unknown ground: scans from before and after share no frame.
TEST(Odometry, BeginsASegmentWhereItIsLostForGood) {
  Drive drive(Loop(1.2), WithMode(OdometryMode::kContinuous));
  for (int k = 0; k < 60; ++k) ASSERT_EQ(drive.Step(k)->segment, 1u);
  Room elsewhere;
  elsewhere.walls = {{-21, -9, -1.6}, {13, 16, 6}};
  elsewhere.boxes = {{{5, 6, -1.6}, {7, 10, 2}}, {{-12, -5, -1.6}, {-10, -4, 3}}};
  const auto there = [](double time_s) {
    return Pose(Eigen::Vector3d(0.8 * std::max(0.0, time_s - 8.0), 0.3, 0));
  };
  std::optional<Pose> T_elsewhere_odom;
  int begun = 0;
  for (int k = 60; k < 130; ++k) {
    const auto result = drive.odometry().Process(MakeScan(elsewhere, there, drive.sensor(), k));
    ASSERT_TRUE(result.ok());
    if (result->segment == 1) {
      EXPECT_EQ(result->status, TrackingStatus::kLost) << k;
      continue;
    }
    ASSERT_EQ(result->segment, 2u);
    const Pose T_elsewhere_sensor = there(0.1 * (k + 1));
    if (!T_elsewhere_odom) {
      begun = k;
      EXPECT_LT(Log(result->T_odom_sensor).norm(), 1e-9);
      T_elsewhere_odom = T_elsewhere_sensor * result->T_odom_sensor.Inverse();
    }
    const Pose error = T_elsewhere_sensor.Inverse() * *T_elsewhere_odom * result->T_odom_sensor;
    EXPECT_NE(result->status, TrackingStatus::kLost) << k;
    EXPECT_LT(error.translation().norm(), 0.1) << k;
  }
  EXPECT_GE(begun, 79);  // Two seconds, in which it is looked for.
  EXPECT_LE(begun, 83);
}

// Picked up and put down between two scans, near enough for false minima.
TEST(Odometry, AKidnappedRobotIsNeverClaimedWhereItIsNot) {
  const Motion motion = Loop(1.2);
  for (const double kidnapped_m : {0.5, 1.0, 2.0, 4.0}) {
    for (const double turned_rad : {0.0, 0.4, 3.1}) {
      SCOPED_TRACE(::testing::Message() << kidnapped_m << " m " << turned_rad << " rad");
      const Pose moved = Pose::FromXyzRpy(-kidnapped_m, 0, 0, 0, 0, turned_rad);
      const auto kidnapped = [&](double time_s) {
        return motion(time_s) * (time_s < 4.0001 ? Pose() : moved);
      };
      Drive drive(kidnapped, WithMode(OdometryMode::kContinuous));
      for (int k = 0; k < 60; ++k) {
        const auto result = drive.Step(k);
        ASSERT_TRUE(result.ok());
        if (result->status != TrackingStatus::kLost) {
          EXPECT_LT(drive.error().translation().norm(), 0.2) << k;
          EXPECT_LT(RotationAngle(drive.error()), 0.05) << k;
        }
        if (k == 40) {
          EXPECT_EQ(result->status, TrackingStatus::kLost);
        }
      }
    }
  }
}

// Put down elsewhere while nothing was sent: a place that fits a little is no place to go on from.
TEST(Odometry, ARobotKidnappedInAGapIsNeverClaimedWhereItIsNot) {
  Room room = FurnishedRoom();  // Without these boxes it would do turned by 180 degrees.
  room.boxes.push_back({{-10, -7, -1.2}, {-2.5, -5.2, 3.8}});
  room.boxes.push_back({{1.5, 5.5, -1.2}, {4, 7, 3.8}});
  room.boxes.push_back({{-10, 2, -1.2}, {-7.5, 3.5, 2}});
  const Motion loop = Loop(1.2);
  for (const double gap_s : {1.0, 30.0}) {
    for (const double back_s : {2.5, 7.5}) {
      SCOPED_TRACE(::testing::Message() << gap_s << " s gap, back by " << back_s << " s");
      const auto kidnapped = [&](double time_s) {
        return loop(time_s < 9.0001 ? time_s : time_s - gap_s - back_s);
      };
      Drive drive(kidnapped, WithMode(OdometryMode::kContinuous), room);
      for (int k = 0; k < 130; ++k) {
        const int after_gap = k < 90 ? 0 : static_cast<int>(10 * gap_s);
        const auto result = drive.Step(k + after_gap);
        ASSERT_TRUE(result.ok());
        if (result->status == TrackingStatus::kLost || result->segment > 1) continue;
        EXPECT_LT(drive.error().translation().norm(), 0.25) << k;
      }
    }
  }
}

}  // namespace
}  // namespace isthmus::floam
