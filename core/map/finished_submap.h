// A submap on its way from a session's odometry to the store.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/map/submap.h"
#include "core/map/trajectory.h"

namespace isthmus {

// All that a later worker of the session needs to go on exactly.
struct SessionCheckpoint {
  uint64_t sequence = 0;  // The last scan dealt with.
  // Up to here all that scans made is in finished submaps: safe without `state`.
  uint64_t durable_sequence = 0;
  std::optional<std::string> state = {};  // Absent on resuming: it is damaged.
  uint32_t segment = 1;                   // The session's segment. Not known on resuming.
};

// A record to be made durable as a whole or not at all.
struct FinishedSubmap {
  std::shared_ptr<const Submap> submap = {};     // Null where there is only a checkpoint.
  std::vector<TrajectoryEntry> trajectory = {};  // The scans that fell into it.
  uint32_t segment = 1;                          // The segment of both.
  // With its state; maybe in a later segment.
  std::optional<SessionCheckpoint> checkpoint = {};
};

}  // namespace isthmus
