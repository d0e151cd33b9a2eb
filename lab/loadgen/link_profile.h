// The kinds of links between robots and server.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace isthmus::loadgen {

// All times in seconds; 0 for what does not happen.
struct LinkProfile {
  double delay_s = 0;        // One way.
  double jitter_s = 0;       // On top of it, up to that; what was sent first arrives first.
  double up_bytes_s = 0;     // Towards the server; 0: no limit.
  double down_bytes_s = 0;   // Towards the robot.
  double stall_every_s = 0;  // Mean time between stretches in which nothing moves ...
  double stall_s = 0;        // ... and their mean length.
  double reset_every_s = 0;  // Mean time between losses of the connection.

  bool is_perfect() const;
};

// "none", "wifi", "4g". InvalidArgument names them.
absl::StatusOr<LinkProfile> FindLinkProfile(const std::string& name);

}  // namespace isthmus::loadgen
