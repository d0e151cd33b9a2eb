// Odometry of a whole drive, with what each scan cost and what was said of it.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"
#include "floam/odometry_options.h"
#include "lab/bench/drive.h"

namespace isthmus::bench {

enum class ScanOutcome { kOk, kDegenerate, kLost, kRejected };

struct ScanRecord {
  ScanOutcome outcome = ScanOutcome::kRejected;
  Pose T_world_sensor;                      // The truth.
  Pose T_odom_sensor;                       // The odometry's pose, unless rejected.
  uint32_t segment = 0;                     // Poses of one segment share a frame.
  std::vector<Eigen::Vector3d> unobserved;  // Unit translations in the sensor frame.
  // CPU time of this thread for all that the odometry did with the scan, and its parts: wall times
  // scaled to that sum.
  double ms = 0;
  double features_ms = 0, matching_ms = 0, map_ms = 0;
  // Kept by the odometry, and the submap in the making; known of some scans only, else 0.
  double heap_mb = 0;
};

struct RunRecord {
  std::vector<ScanRecord> scans;  // One per shot.
  double cal_ms = 0;              // The less of what it was before and after.
  double odometry_mb = 0;         // Kept by the odometry at the end.
  double peak_mb = 0;             // The process's: simulator and scans in wait included.
};

// Processes the drive on the calling thread, as a session of the server does: submaps are cut, and
// the odometry remembers them; only cutting them is not counted as its cost. Scans are made a few
// at a time, apart from what is measured. NotFound for a sensor the odometry does not know.
absl::StatusOr<RunRecord> Run(const Drive& drive, const floam::OdometryOptions& options);

}  // namespace isthmus::bench
