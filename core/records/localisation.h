// Localisation as it is asked for, and what is told of each scan.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ids.h"
#include "core/odometry_mode.h"
#include "core/pose.h"
#include "core/tracking.h"

namespace isthmus {

struct LocalisationRequest {
  std::string sensor = {};                    // Name of a sensor model, e.g. "vlp16".
  Pose T_base_sensor = {};                    // Extrinsic.
  std::optional<OdometryMode> odometry = {};  // Absent: the server's own choice.
  // The robot of the scans, for clients that look on; empty: nobody is told.
  RobotId robot = {};
  // In the map that this robot's newest session is in; empty: in the largest.
  RobotId in_map_of = {};
};

enum class LocalisationState : uint8_t {
  kSearching,  // The place is not known.
  kAmbiguous,  // Several places look alike.
  kLocated,
  kUncertain,  // Led by odometry from a known place: beyond the map, or contradicted by it.
};

// Stable lower-case name ("located"), for people and JSON.
const char* ToString(LocalisationState state);

struct LocalisedScan {
  uint64_t sequence = 0;
  LocalisationState state = LocalisationState::kSearching;
  std::string rejected = {};  // Why the scan could not be used; else empty.
  // At the END of the scan, while located or uncertain. The covariance: twist order [rho; phi],
  // sensor frame, m^2 and rad^2.
  std::optional<Pose> T_map_sensor = {};
  std::optional<Matrix6d> covariance = {};
  std::optional<Pose> T_map_odom = {};
  std::optional<Pose> T_odom_sensor = {};  // In a frame of the stream's own, unless rejected.
  Tracking tracking = Tracking::kUnknown;
  uint32_t segment = 1;  // Poses in odom of different segments share no frame.
  int64_t revision = 0;  // Revision of the map that was searched.
  uint32_t component = 0;
  double odometry_ms = 0, localising_ms = 0;  // Computing time, decoding apart.
};

}  // namespace isthmus
