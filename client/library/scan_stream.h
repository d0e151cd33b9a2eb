// One robot's scans on their way to the server.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"
#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::client {

enum class ScanOutcome {
  kProcessed,
  kDuplicate,  // The server had it already, from before a lost link.
  kRejected,   // Cannot be used; `reason` says why.
};

// Computing time of one scan's odometry at the server, wall time, decoding apart.
struct ScanTiming {
  double features_ms = 0, matching_ms = 0, map_ms = 0, total_ms = 0;
};

struct ScanAck {
  uint64_t sequence = 0;
  int64_t end_stamp_ns = 0;
  ScanOutcome outcome = ScanOutcome::kProcessed;
  std::string reason;
  std::string tracking;               // "ok", "degenerate" or "lost" when processed.
  std::optional<Pose> T_odom_sensor;  // At the END of the scan, when processed.
  // Of T_odom_sensor, relative to the map around the robot (drift adds to it): twist order
  // [rho; phi], sensor frame at the END of the scan, m^2 and rad^2. When processed.
  std::optional<Matrix6d> covariance;
  // Directions that the scan did not observe, along which the prediction was kept: unit vectors,
  // sensor frame at the END of the scan. When degenerate.
  std::vector<Eigen::Vector3d> unobserved_translations, unobserved_rotations;
  std::optional<Pose> T_map_odom;  // Newest; absent until the session has been placed.
  uint64_t durable_sequence = 0;
  ScanTiming timing;  // When processed.
};

struct ScanStreamOptions {
  // Scans without acknowledgement; Push waits when there are as many.
  size_t window = 16;
  // Acknowledged scans are kept up to this size until they are durable, to be sent again should
  // the server crash.
  size_t spool_bytes = 256u << 20;
  // Sends x, y, z rounded to this, compressed (0.001 to 0.005 is usual); 0: as they are. Payloads
  // that are compressed already are sent as they are.
  double resolution_m = 0;
  // Called once per scan, in order, from a thread of the stream. Must not call the stream.
  std::function<void(const ScanAck&)> on_ack = nullptr;
};

struct ScanStreamStats {
  uint64_t pushed = 0, processed = 0, duplicates = 0, rejected = 0;
  uint64_t durable_sequence = 0;
  uint64_t sent_bytes = 0;  // Of clouds, what was sent again included.
  int reconnects = 0;
};

// Thread safe, though scans of one robot come from one thread. When the link is lost it is opened
// again, with back-off, and whatever the server lacks is sent again: nothing is lost and nothing
// counts twice. After backoff.max_attempts without any acknowledgement in between it gives up, and
// from then on every call returns that error.
class ScanStream {
 public:
  // Gives up what is not acknowledged; call Finish first.
  ~ScanStream();

  // Hands over a scan; stamp is the END of it. Waits while the window is full. InvalidArgument for
  // a payload that cannot be compressed: it was not taken, and the stream goes on.
  absl::Status Push(int64_t end_stamp_ns, PointPayload payload);
  absl::Status Push(const Scan& scan);  // Its sequence is not used: the stream counts.

  // Waits until every scan is acknowledged and closes the stream. The session stays open, see
  // Client::FinishSession. Idempotent.
  absl::Status Finish();

  ScanStreamStats stats() const;

  class Impl;  // Private to the library.
  explicit ScanStream(std::unique_ptr<Impl> impl);

 private:
  const std::unique_ptr<Impl> impl_;
};

}  // namespace isthmus::client
