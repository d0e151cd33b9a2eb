// A drive through a room as the odometry follows it, and how far that is from the truth.
#pragma once

#include <absl/status/statusor.h>
#include <gtest/gtest.h>

#include <cmath>

#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "tests/floam/room.h"

namespace isthmus::floam::testing {

inline SensorModel Vlp16() { return *FindSensorModel("vlp16"); }

inline OdometryOptions WithMode(OdometryMode mode) {
  OdometryOptions options;
  options.mode = mode;
  options.undistort_cloud = false;
  return options;
}

// Root mean square distance of the estimated END positions from the true ones. The first pose
// places the odom frame.
class Drive {
 public:
  Drive(const Motion& motion, const OdometryOptions& options, const Room& room = FurnishedRoom())
      : room_(room), motion_(motion), odometry_(Vlp16(), options) {}

  absl::StatusOr<OdometryResult> Step(int index) {
    return Process(MakeScan(room_, motion_, sensor_, index), index);
  }

  absl::StatusOr<OdometryResult> Process(const Scan& scan, int index) {
    absl::StatusOr<OdometryResult> result = odometry_.Process(scan);
    if (!result.ok()) return result;
    const Pose truth = EndPose(motion_, sensor_, index);
    if (count_ == 0) T_world_odom_ = truth * result->T_odom_sensor.Inverse();
    error_ = truth.Inverse() * (T_world_odom_ * result->T_odom_sensor);
    sum_ += error_.translation().squaredNorm();
    ++count_;
    return result;
  }

  double Rmse() const { return std::sqrt(sum_ / count_); }
  const Pose& error() const { return error_; }  // The last pose's error.
  const Sensor& sensor() const { return sensor_; }
  const Room& room() const { return room_; }
  Odometry& odometry() { return odometry_; }

 private:
  const Room room_;
  const Sensor sensor_;
  const Motion motion_;
  Odometry odometry_;
  Pose T_world_odom_, error_;
  double sum_ = 0;
  int count_ = 0;
};

// Goes on with scans [begin, end): from the sixth on all is well again.
inline void ExpectTrackedAgain(Drive* drive, int begin, int end) {
  for (int k = begin; k < end; ++k) {
    const auto result = drive->Step(k);
    ASSERT_TRUE(result.ok());
    if (k > begin + 5) {
      EXPECT_EQ(result->status, TrackingStatus::kOk) << k;
      EXPECT_TRUE(result->unobserved_covariance.isZero(0)) << k;
    }
  }
  EXPECT_LT(drive->error().translation().norm(), 0.05);
}

}  // namespace isthmus::floam::testing
