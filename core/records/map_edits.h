// A person's decision on the map, and what came of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ids.h"
#include "core/map/manual_decision.h"
#include "core/pose.h"
#include "core/records/map_graph.h"

namespace isthmus {

// On a pair of sessions. Without a session the robot's newest is meant.
struct MatchDecision {
  RobotId robot_a = {}, robot_b = {};
  SessionId session_a = {}, session_b = {};
  std::optional<ManualDecisionKind> kind =
      {};                 // Absent: what was said is withdrawn, the computed holds.
  Pose T_a_b = {};        // For ManualDecisionKind::kSet: b's odom frame to a's, as named here.
  std::string note = {};  // Why; at most 1000 characters.
};

struct DecidedMatch {
  int64_t revision = 0;  // Revision of the map placed anew.
  MatchEdge edge;        // As it counts from now on; kNotYet where nothing is known of the pair.
};

// On a loop closure.
struct LoopDecision {
  uint64_t id = 0;
  bool rejected = true;   // False: it counts again.
  std::string note = {};  // At most 1000 characters.
};

struct DecidedLoop {
  int64_t revision = 0;
  Loop loop;  // As it counts from now on.
};

// The outcome of putting an anchor.
struct Anchored {
  int64_t revision = 0;  // Revision of the map with it.
  SubmapId submap;
};

}  // namespace isthmus
