// Scans that take far more work than others are cut off after so many steps, the same every time,
// and the drive goes on as if they had not come.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "floam/map/local_map.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/scan/scan_frame.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::FurnishedRoom;
using ::testing::HasSubstr;
using testing::Loop;
using testing::MakeScan;
using testing::MakeScanWithoutRings;
using testing::Sensor;

constexpr double kTurn = 2 * std::numbers::pi;

Scan Empty(int index, bool in_rings) {
  Scan scan;
  scan.sequence = index + 1;
  scan.end_stamp_ns = 1'000'000'000 + (index + 1) * int64_t{100'000'000};  // As MakeScan's.
  scan.has_ring = scan.has_time = in_rings;
  return scan;
}

ScanPoint PointAt(double x, double y, double z, int ring = 0, double time = 0) {
  ScanPoint p;
  p.x = static_cast<float>(x);
  p.y = static_cast<float>(y);
  p.z = static_cast<float>(z);
  p.ring = static_cast<uint16_t>(ring);
  p.time = static_cast<float>(time);
  return p;
}

// In the middle of a shaft, 100 m high and 1.6 m wide: nearly all points lie straight up or down.
Scan Shaft(int index, int points) {
  Scan scan = Empty(index, false);
  for (int i = 0; i < points; ++i) {
    const double part = static_cast<double>(i) / points;
    const double angle = part * kTurn * 500;
    scan.points.push_back(PointAt(0.8 * std::cos(angle), 0.8 * std::sin(angle), 100 * part - 50));
  }
  return scan;
}

// A ball around a sensor of very many rings.
Scan Ball(int index, int rings, int columns) {
  Scan scan = Empty(index, true);
  for (int ring = 0; ring < rings; ++ring) {
    const double up = (static_cast<double>(ring) / rings - 0.5) * 0.95 * std::numbers::pi;
    for (int i = 0; i < columns; ++i) {
      const double part = static_cast<double>(i) / columns;
      const double angle = kTurn * (part - 0.5);
      scan.points.push_back(PointAt(40 * std::cos(angle) * std::cos(up),
                                    40 * std::sin(angle) * std::cos(up), 40 * std::sin(up), ring,
                                    0.1 * (part - 1)));
    }
  }
  return scan;
}

Scan WithoutRings(int index) {
  return MakeScanWithoutRings(FurnishedRoom(), Loop(1), testing::Scattered, 12'000, index);
}

OdometryOptions MostWork(uint64_t steps) {
  OdometryOptions options;
  options.features.max_work = steps;
  options.undistort_cloud = false;
  return options;
}

uint64_t StepsOf(const Odometry& odometry) { return odometry.frame().features.work.steps(); }

TEST(CostlyScans, PointsInTheSameDirectionsAreCutOffAndTheDriveGoesOnAsWithoutThem) {
  constexpr uint64_t kMost = 3'000'000;
  const SensorModel sensor = *FindSensorModel("unordered");
  Odometry odometry(sensor, MostWork(kMost)), spared(sensor, MostWork(kMost));
  for (int k = 0; k < 12; ++k) {
    if (k == 6) {
      const auto rejected = odometry.Process(Shaft(k, 40'000));
      ASSERT_TRUE(absl::IsInvalidArgument(rejected.status())) << rejected.status();
      EXPECT_THAT(std::string(rejected.status().message()), HasSubstr("steps of work"));
      EXPECT_THAT(std::string(rejected.status().message()), HasSubstr("the same directions"));
      // In time: with what a single point has around it, at most.
      EXPECT_LE(StepsOf(odometry), kMost + 40'000);
      continue;
    }
    const auto result = odometry.Process(WithoutRings(k));
    const auto expected = spared.Process(WithoutRings(k));
    ASSERT_TRUE(result.ok() && expected.ok()) << k << ": " << result.status();
    EXPECT_EQ(result->status, expected->status) << k;
    EXPECT_EQ(result->T_odom_sensor.translation(), expected->T_odom_sensor.translation()) << k;
  }
}

TEST(CostlyScans, RingsThatTakeLongToMatchAreCutOffAndTheDriveGoesOn) {
  const SensorModel sensor = *FindSensorModel("spinning");
  Odometry free(sensor, MostWork(kMaxScanWork));
  const auto first = free.Process(Ball(0, 512, 290));
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_TRUE(free.Process(Ball(1, 512, 290)).ok());
  const uint64_t needed = StepsOf(free);

  const uint64_t most = needed / 2;
  Odometry odometry(sensor, MostWork(most));
  ASSERT_TRUE(odometry.Process(Ball(0, 512, 290)).ok());
  const auto rejected = odometry.Process(Ball(1, 512, 290));
  ASSERT_TRUE(absl::IsInvalidArgument(rejected.status())) << rejected.status();
  EXPECT_THAT(std::string(rejected.status().message()), HasSubstr("in the scan before"));
  EXPECT_LE(StepsOf(odometry), most + 200'000);
  // Then the robot sees a room. The first scans are compared with that ball still.
  for (int k = 2; k < 20; ++k) {
    const auto result = odometry.Process(MakeScan(FurnishedRoom(), Loop(1), Sensor(), k));
    if (k < 8) continue;
    ASSERT_TRUE(result.ok()) << k << ": " << result.status();
    EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
  }
}

TEST(CostlyScans, TakeTheSameStepsEveryTime) {
  uint64_t steps[2] = {};
  for (uint64_t& sum : steps) {
    Odometry odometry(*FindSensorModel("unordered"), MostWork(3'000'000));
    const auto rejected = odometry.Process(Shaft(0, 40'000));
    EXPECT_FALSE(rejected.ok());
    sum = StepsOf(odometry);
    for (int k = 1; k < 4; ++k) {
      const auto result = odometry.Process(WithoutRings(k));
      EXPECT_TRUE(result.ok()) << result.status();
      sum += StepsOf(odometry);
    }
  }
  EXPECT_EQ(steps[0], steps[1]);
}

TEST(CostlyScans, UsualOnesAreFarFromTheLimit) {
  Sensor sensor;
  sensor.rings = 128;
  sensor.columns = 1024;
  sensor.lowest_rad = -0.39;
  sensor.highest_rad = 0.39;
  Odometry in_rings(*FindSensorModel("spinning"), OdometryOptions());
  Odometry without(*FindSensorModel("unordered"), OdometryOptions());
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(in_rings.Process(MakeScan(FurnishedRoom(), Loop(1), sensor, k)).ok());
    EXPECT_GT(StepsOf(in_rings), 0u);
    EXPECT_LT(StepsOf(in_rings), kMaxScanWork / 5) << k;
    ASSERT_TRUE(without.Process(WithoutRings(k)).ok());
    EXPECT_LT(StepsOf(without), kMaxScanWork / 20) << k;
  }
}

TEST(CostlyScans, OfEverOtherPlacesFillNoMemory) {
  LocalMapOptions options;
  options.max_blocks = 1000;
  LocalMap map(ShapeKind::kPlane, options);
  for (int i = 0; i < 5000; ++i) map.Insert({static_cast<double>(i), 0, 0});
  EXPECT_EQ(map.block_count(), 2000u);
  // Existing blocks go on taking points.
  for (int i = 0; i < 10; ++i) {
    map.Insert({0.3 + 0.04 * (i % 3), 0.3 + 0.05 * i, 0.4}, static_cast<float>(i % 2));
  }
  LocalMap::Found found;
  map.Find({0.35, 0.5, 0.4}, &found);
  EXPECT_EQ(map.block_count(), 2000u);
}

}  // namespace
}  // namespace isthmus::floam
