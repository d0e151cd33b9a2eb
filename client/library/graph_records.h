// The server's answers about revisions, loop closures and anchors, as plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/anchor.h"
#include "core/ids.h"
#include "core/loop_closure.h"
#include "core/pose.h"
#include "core/revision.h"
#include "core/submap.h"

namespace isthmus::client {

struct SubmapStatus {
  SubmapInfo info;
  std::optional<uint32_t> component;  // Absent until the submap has been placed.
  Pose T_map_submap;                  // Where it lies then.
};

// The changes of the map from one revision to another.
struct RevisionDiff {
  int64_t from = 0, to = 0;
  std::vector<RevisionInfo> revisions;  // After `from` up to `to`, the newest first.
  std::vector<SubmapMove> moves;  // In order of submap, each once; those that came back left out.
};

struct Loop {
  LoopClosure loop;  // Edges only if asked for.
  RobotId robot;
  uint32_t edge_count = 0;
  uint32_t edges_used = 0;  // Which the map agrees with; the others were set aside as outliers.
};

// A person's word on a loop closure.
struct LoopDecision {
  uint64_t id = 0;
  bool rejected = true;  // False: it counts again.
  std::string note = {};
};

struct RobotAnchor {
  Anchor anchor;
  RobotId robot;  // Whose submap it is.
};

// The result of putting an anchor.
struct Anchored {
  int64_t revision = 0;  // Of the map with it.
  SubmapId submap;
};

}  // namespace isthmus::client
