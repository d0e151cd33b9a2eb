// F-LOAM odometry of one robot: scans in, poses in its odom frame out.
//
// H. Wang, C. Wang, C.-L. Chen, L. Xie, "F-LOAM: Fast LiDAR Odometry and Mapping", IROS 2021, as
// used per robot in "Multi-Robot SLAM Using Fast LiDAR Odometry and Mapping".
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/cloud.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "core/pose.h"
#include "core/scan.h"
#include "floam/match/degeneracy.h"
#include "floam/rings/ring_scan.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

class MatchQuality;      // floam/match/match_quality.h
struct OdometryOptions;  // floam/odometry_options.h
struct ScanFrame;        // floam/scan/scan_frame.h

enum class TrackingStatus {
  kOk,
  kDegenerate,  // Some direction is not observed; how the motion went on decided along it.
  kLost,        // The scan could not be matched, or so badly that the pose is not to be trusted.
};

struct ScanTiming {
  double features_ms = 0;  // Ring and time inference, smoothness, selection.
  double matching_ms = 0;  // Undistortion and scan-to-map matching, both stages.
  double map_ms = 0;       // Local map update.
  double total_ms = 0;
};

struct OdometryResult {
  uint64_t sequence = 0;
  int64_t stamp_ns = 0;  // END of the scan.
  // Counted from 1. A robot that is lost for good begins a new one, with an odom frame of its own:
  // poses of different segments have nothing to do with each other.
  uint32_t segment = 1;
  Pose T_odom_sensor;  // At the END of the scan; identity for the first of a segment.
  // The covariance of T_odom_sensor relative to the map around the sensor, whose drift comes on
  // top; twist order [rho; phi], sensor frame at the END of the scan, m^2 and rad^2.
  Matrix6d covariance = Matrix6d::Zero();
  // The covariance by the match alone, in the same terms: not large along what it does not observe.
  Matrix6d matched_covariance = Matrix6d::Zero();
  // The covariance of the unobserved part of the motion since the scan before; see
  // UnobservedMotion.
  Matrix6d unobserved_covariance = Matrix6d::Zero();
  TrackingStatus status = TrackingStatus::kOk;
  Degeneracy degeneracy;  // Directions, when degenerate; sensor frame at the END of the scan.
  Inference rings_from = Inference::kSensor;
  Inference times_from = Inference::kSensor;
  InputText input;  // The same in words.
  ScanTiming timing;
  // All usable points of the scan, undistorted into the sensor frame at the END of the scan.
  Cloud undistorted;
};

// One per session. Not thread safe; starts no threads. Process must be called in order of time.
class Odometry {
 public:
  Odometry(const SensorModel& sensor, const OdometryOptions& options);
  ~Odometry();

  // InvalidArgument when the scan cannot be used (too few points, all in one place, non-finite
  // coordinates, time going backwards); the state is then as before the call. Also when it takes
  // more work than FeatureOptions::max_work, counted in steps: where that shows only while it is
  // matched, what was found out about a lost robot may be lost, and the drive goes on as if the
  // scan had not come.
  absl::StatusOr<OdometryResult> Process(const Scan& scan);

  // Goes on in the odom frame of an earlier run: `map_odom` is what that run saw around its last
  // pose (odom frame), `recent` its last scans' poses T_odom_sensor in order of time; one at least,
  // of which the last two tell the motion; both of its segment `segment`. Call before the first
  // Process.
  void Resume(const Cloud& map_odom, const Trajectory& recent, uint32_t segment = 1);

  // A finished submap of this segment, or of its earlier run: where to look for the sensor, should
  // it be kidnapped. See Relocaliser. Without any, it is only found near where it was last. With
  // a new segment all are forgotten.
  void Remember(const Submap& submap);

  // All that later results depend on but what is remembered, exactly: one that is restored goes on
  // bit for bit as this one does. For the same program and processor only.
  std::string Save() const;
  // Becomes the one that was saved, with what was remembered here before; to be called on a new
  // one, with the submaps that the saved one knew. InvalidArgument for the state of another
  // version, sensor or options, DataLoss for one that is damaged; nothing has changed then.
  absl::Status Restore(const std::string& saved);

  // The scan that was processed last, ready for matching, and how well scans are matched as a rule:
  // for who looks for it in another map. Good until the next Process.
  const ScanFrame& frame() const;
  const MatchQuality& quality() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::floam
