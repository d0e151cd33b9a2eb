// The options that name a recording, and the robots in it. Shared by `push`, `odometry`, `merge`
// and `info`.
#pragma once

#include <absl/status/statusor.h>

#include <CLI/App.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/recording.h"
#include "client/readers/started_reader.h"
#include "core/odometry_mode.h"
#include "core/pose.h"

namespace isthmus::cli {

struct RecordingOptions {
  std::vector<std::string> topics;  // "TOPIC" or "TOPIC=ROBOT".
  readers::ReadOptions read;
};

// --topic, --from, --to, and those of AddReadOptions.
void AddRecordingOptions(CLI::App& command, RecordingOptions& options);
// --sensor, --stamps, --compensated, --metadata and --calibration.
void AddReadOptions(CLI::App& command, readers::ReadOptions& options);

// --odometry: which one; stays absent, the server's own choice, unless given.
void AddOdometryMode(CLI::App& command, std::optional<OdometryMode>& mode);

// One robot's scans.
struct RobotScans {
  std::string robot;  // Empty where nothing names it.
  std::string topic;
  std::string sensor;
  std::unique_ptr<readers::StartedReader> reader;
  // Opens the same scans once more, for as long as the recording lives; null where it does not.
  std::function<absl::StatusOr<std::unique_ptr<readers::ScanReader>>()> read_again;
  std::vector<std::string> assumptions;  // The reader's, as far as they were said.
  std::string frame;                     // The points', as the recording names it; else empty.
  std::optional<Pose> T_base_sensor;  // As the recording's static transforms have it, if they do.
};

// The robots of a recording: those that --topic names, else its only topic. What is assumed goes to
// stderr, a line each. NotFound for a topic that is not there; InvalidArgument, naming the topics,
// where there are several and none was chosen. The robots of a path have no read_again.
absl::StatusOr<std::vector<RobotScans>> OpenRobots(const std::string& path,
                                                   const RecordingOptions& options);
absl::StatusOr<std::vector<RobotScans>> OpenRobots(const readers::Recording& recording,
                                                   const std::string& path,
                                                   const RecordingOptions& options);

}  // namespace isthmus::cli
