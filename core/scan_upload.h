// A scan on its way in, and what the robot is told about it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/map/session.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/scan_timing.h"
#include "core/tracking.h"

namespace isthmus {

// A scan as a robot sent it, still encoded.
struct ScanUpload {
  uint64_t sequence = 0;     // From 1, increasing by 1.
  int64_t end_stamp_ns = 0;  // Unix nanoseconds, END of the scan.
  PointPayload payload;
  int64_t arrived_ns = 0;  // At the server, by its steady clock; 0: when it was submitted.
};

enum class ScanOutcome {
  kProcessed,  // Took effect.
  kDuplicate,  // The sequence was seen before, as after a lost link; ignored.
  kRejected,   // Cannot be used, see reason; sending it again will not help.
  kSkipped,    // Newer ones came while it waited, see WhenBehind; its sequence is used up.
};

// The outcome of a scan.
struct ScanAck {
  // The scan's session and END: only its sender fills them in, see ScanStream.
  SessionId session;
  int64_t end_stamp_ns = 0;
  uint64_t sequence = 0;  // 0 in an ack that only moves durable_sequence.
  ScanOutcome outcome = ScanOutcome::kProcessed;
  std::string reason;  // Empty when processed.
  // When processed. Lost as well when a scan cannot be used for what it holds: where the robot was
  // then is not known.
  Tracking tracking = Tracking::kUnknown;
  std::optional<Pose> T_odom_sensor;  // At the END of the scan; when processed.
  // The covariance of T_odom_sensor relative to the map around the robot: twist order [rho; phi],
  // sensor frame at the END of the scan, m^2 and rad^2. When processed.
  std::optional<Matrix6d> covariance;
  // Directions that the scan does not observe, along which the prediction was kept: unit vectors,
  // sensor frame at the END of the scan. When degenerate.
  std::vector<Eigen::Vector3d> unobserved_translations, unobserved_rotations;
  // The segment that the session is in, from 1 on, and its id: both poses are of its odom frame.
  uint32_t segment = 1;
  SessionId segment_session;
  std::optional<Pose> T_map_odom;  // Newest; absent until the segment has been placed.
  int64_t lost_since_ns = 0;       // END of the first scan since it was tracked last; 0: it is.
  ScanCounts scans;                // Scans of the session, up to this one.
  uint64_t durable_sequence = 0;   // Scans up to here survive a crash of the server.
  ScanTiming timing;               // When processed.
};

// Called one ack at a time per session, in order of the scans. Must not call back into the pipeline
// and should return soon: the session's next scan waits for it.
using AckSink = std::function<void(const ScanAck&)>;

}  // namespace isthmus
