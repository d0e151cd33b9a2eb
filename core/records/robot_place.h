// The place of a robot that is under way, to what the server knows.
#pragma once

#include <cstdint>
#include <optional>

#include "core/ids.h"
#include "core/pose.h"
#include "core/records/localisation.h"
#include "core/tracking.h"

namespace isthmus {

// The state of a robot that is found in the map that others made. Times are the server's clock's.
struct Localising {
  LocalisationState state = LocalisationState::kSearching;  // As of its newest scan.
  Tracking tracking = Tracking::kUnknown;                   // As of its newest scan.
  int64_t since_ns = 0;                                     // When its stream began.
  int64_t received_ns = 0;           // When its newest scan came; 0: none has.
  uint64_t scans = 0, rejected = 0;  // In this stream; the first count holds the second.
};

struct RobotPlace {
  RobotId robot;                           // Empty only where one that is localised gave no name.
  SessionId session = {};                  // Its segment, where the session has several.
  std::optional<uint32_t> component = {};  // Absent until it is placed, or located.
  Pose T_map_sensor = {};                  // At its newest scan that was dealt with.
  int64_t stamp_ns = 0;                    // Stamp of that scan.
  double lag_ms = 0;  // Wait of the oldest scan that was not dealt with; 0: none.
  // Set for one that is localised, and has no session.
  std::optional<Localising> localising = {};
};

}  // namespace isthmus
