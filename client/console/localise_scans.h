// The loop that asks, scan by scan, where a robot is: `push --localise`.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/library/client.h"
#include "core/map/trajectory.h"

namespace isthmus::cli {

struct LocaliseSummary {
  std::string robot, sensor;
  uint64_t scans = 0, rejected = 0, unreadable = 0;
  uint64_t located = 0, uncertain = 0, ambiguous = 0, searching = 0;
  std::optional<double> first_pose_s;  // After the first scan, by the stamps.
  Trajectory poses;                    // T_map_sensor, while located or uncertain.
  LocalisedScan last;
  // Means, of the scans that could be used; nothing without one.
  std::optional<double> odometry_ms, localising_ms;
  double seconds = 0;  // Wall time.
  bool is_interrupted = false;
};

// Says on stderr when the state changes. `in_map_of`: see LocalisationRequest. Ends with the
// recording, or when stopped.
absl::StatusOr<LocaliseSummary> LocaliseRobot(client::Client& client, RobotScans robot,
                                              const std::string& in_map_of,
                                              const PushOptions& options, PushControl& control);

}  // namespace isthmus::cli
