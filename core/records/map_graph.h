// The match graph: pairs of sessions, loop closures, and where they place the sessions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/ids.h"
#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/manual_decision.h"
#include "core/map/match.h"
#include "core/map/revision.h"

namespace isthmus {

// A drive that a match asks for, in the map of the robot that is to drive.
struct RobotDrive {
  RobotId robot;
  SessionId session;
  Pose T_a_b;                        // As the maps would lie.
  std::vector<Eigen::Vector3d> way;  // The sensor's, from its newest pose in a submap on.
  uint32_t leaves_own = 0;           // The last of them where the robot has been.
  double length_m = 0;
  double confidence = 0;  // The match's afterwards, if the maps do lie like this.
};

struct MatchEdge {
  Match match;
  RobotId robot_a = {}, robot_b = {};
  bool in_tree = false;  // Carries a placement.
  // The person's decision on the pair: `match` is then as they want it.
  std::optional<ManualDecision> manual_decision = std::nullopt;
  std::vector<RobotDrive> asked_drives = {};  // None of robots whose sessions are finished.
};

struct PlacedSession {
  Placement placement;  // Without its submaps.
  RobotId robot = {};
};

struct MatchGraph {
  int64_t revision = 0;
  std::vector<MatchEdge> matches;
  std::vector<PlacedSession> placements;
};

struct Loop {
  LoopClosure loop;
  RobotId robot = {};
  uint32_t edge_count = 0;  // Number of loop.edges, also if these are not told.
  uint32_t edges_used = 0;  // Edges that the map agrees with; it set the others aside as outliers.
};

struct RobotAnchor {
  Anchor anchor;
  RobotId robot = {};  // The robot of the submap.
};

// The changes of the map from one revision to another.
struct RevisionDiff {
  int64_t from = 0, to = 0;
  std::vector<SubmapMove> moves;  // In order of submap, each once; those that came back left out.
  std::vector<RevisionInfo> revisions;  // After `from` up to `to`, the newest first.
};

}  // namespace isthmus
