// Revisions of the merged map: where every submap lies, and what changed from one to the next.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

// One submap of a session whose name is known from elsewhere.
struct SubmapPose {
  uint32_t index = 0;
  Pose T_map_submap;
};

// A session in its component. Each component has one map frame: that in which the reference
// session's first submap lies as in its odom frame, or, where anchors hold the component, theirs.
struct Placement {
  SessionId session;
  uint32_t component = 0;  // 0 is the largest component; every lone session is one of its own.
  SessionId reference;     // Names the component's map frame.
  Pose T_map_odom;         // At its newest submap: what takes the robot's newest poses to the map.
  std::vector<SubmapPose> submaps = {};  // In order of index; retired ones are not there.
};

// Grows by one whenever a submap is placed, moved or taken out. Revision 0 is the empty map.
struct MapRevision {
  int64_t revision = 0;
  int64_t stamp_ns = 0;
  std::string cause;  // For a person: "match alice-1 ~ bob-1 ACCEPTED; submap alice-1/7".
  // The findings and decisions since the revision before: what to reject to undo this one.
  std::vector<std::pair<SessionId, SessionId>> matches = {};
  std::vector<uint64_t> loops = {};        // LoopClosure::id.
  std::vector<Placement> placements = {};  // In order of session id.
};

// The effect of a revision on one submap.
struct SubmapMove {
  SubmapId submap;
  // In the map frame named after `frame_before`; absent for one that was not in the map before.
  std::optional<Pose> before = {};
  SessionId frame_before = {};
  // In the map frame named after `frame_after`; absent for one that left the map.
  std::optional<Pose> after = {};
  SessionId frame_after = {};
};

// A revision without its poses.
struct RevisionInfo {
  int64_t revision = 0;
  int64_t stamp_ns = 0;
  std::string cause;
  std::vector<std::pair<SessionId, SessionId>> matches = {};
  std::vector<uint64_t> loops = {};
  uint32_t added = 0, moved = 0, removed = 0;  // Submaps.
  double largest_move_m = 0;                   // Among submaps that moved within one frame.
};

}  // namespace isthmus
