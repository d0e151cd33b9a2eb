// A robot that is followed where this program runs, and sends its submaps instead of its scans: for
// links that do not carry scans.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/library/client.h"

namespace isthmus::cli {

struct KeyframeHooks {
  std::function<void(const ScanAck&)> on_ack;  // Answers of this program's own odometry.
  // A scan that could not be read.
  std::function<void(const std::string& name, const absl::Status& why)> left_out;
};

struct KeyframeSummary {
  SessionId session;                         // The newest segment; empty if no submap came about.
  client::ScanStreamStats scans;             // sent_bytes: of submaps.
  std::optional<uint64_t> durable_sequence;  // Nothing where some submap was dropped.
  ScanCounts counts;
  uint32_t segments = 1;
  bool was_finished = false;  // The newest segment's session, before.
};

// Reads the scans, follows them, and uploads the submaps that the server would have made of them:
// thinned keyframes, rounded to options.resolution_m. A segment is a session of its own. Submaps
// wait in memory while the server is out of reach, up to 256 MB; beyond that no scan is read. Begun
// again with the same recording it goes on where it was cut off. Stopped: a live robot sends what
// is unfinished, else it is dropped and the session stays open.
absl::StatusOr<KeyframeSummary> PushKeyframes(client::Client& client, RobotScans& robot,
                                              const PushOptions& options,
                                              const PushControl& control,
                                              const KeyframeHooks& hooks);

}  // namespace isthmus::cli
