// A session as it is stored and reported.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ids.h"
#include "core/odometry_mode.h"
#include "core/pose.h"

namespace isthmus {

enum class SessionState {
  kActive,    // Takes scans and submaps.
  kFinished,  // Closed by the robot; its map stays.
};

// The treatment of a session's scans that come faster than the server deals with them.
enum class WhenBehind {
  kWait,        // The robot is slowed down; every scan is used.
  kKeepNewest,  // The oldest that waits is skipped, so that the pose is of the newest.
};

// Counts of scans by outcome.
struct ScanCounts {
  uint64_t ok = 0, degenerate = 0, lost = 0, rejected = 0;
  uint64_t skipped = 0;  // Newer ones came while they waited, see WhenBehind.

  friend bool operator==(const ScanCounts&, const ScanCounts&) = default;
};

// A robot's request for a session: all that robots choose of it, which is stored with it.
struct SessionRequest {
  RobotId robot = {};
  std::string sensor = {};                    // Name of a sensor model, e.g. "vlp16".
  std::optional<OdometryMode> odometry = {};  // Absent: the server's own choice.
  Pose T_base_sensor = {};                    // Extrinsic; identity unless given.
  // Chosen by the client: asking again with the same one, for the same robot, returns the session
  // that was opened the first time. At most 64 characters; empty: a new session whatever was.
  std::string request_id = {};
  WhenBehind when_behind = WhenBehind::kWait;
};

// A robot that stays lost goes on in a new segment: a session of its own, with its own odom frame
// and submaps, that is opened by the server and finished and deleted with the session that the
// robot opened. The robot's own session is the first segment.
struct SessionRecord : SessionRequest {
  SessionId id = {};
  SessionState state = SessionState::kActive;
  int64_t created_ns = 0;
  int64_t finished_ns = 0;  // 0 while active.
  uint32_t segment = 1;
  SessionId first_segment = {};  // For a later segment: the session that the robot opened.
  ScanCounts scans = {};         // Over all segments; known here once it is finished, in the first.

  // The session that the robot opened.
  const SessionId& opened() const { return first_segment.empty() ? id : first_segment; }
};

// "alice-1" is the first segment of session "alice-1", "alice-1.2" the second. No session that a
// robot opens has such an id: it ends in a hyphen and digits.
inline SessionId SegmentId(const SessionId& opened, uint32_t segment) {
  return segment <= 1 ? opened : SessionId(opened.value() + "." + std::to_string(segment));
}

}  // namespace isthmus
