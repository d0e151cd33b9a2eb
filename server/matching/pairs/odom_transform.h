// One rigid transform for two maps whose submaps lie to each other as edges say, in whichever
// frames: those of the odometry, or of the shapes that loops gave the maps.
#pragma once

#include <optional>
#include <vector>

#include "core/map/match.h"
#include "core/pose.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// The poses of two maps' submaps, each in its own map's frame.
struct FramePoses {
  std::vector<Pose> a, b;

  // T_odom_submap as the maps have it, and as odometry has it. The same where neither has a shape.
  static FramePoses AsMatched(const SessionMap& a, const SessionMap& b);
  static FramePoses ByOdometry(const PreparedMap& a, const PreparedMap& b);
};

// The T_a_b that the edges agree on best; nothing without edges. `submap_a` and `submap_b` of edges
// are positions, here as below.
std::optional<Pose> FitRigid(const FramePoses& poses, const std::vector<SubmapEdge>& edges,
                             const Pose& guess);

// The T_a_b between the frames of `to` that says the same as `T_a_b` between those of `from`: by
// the edges or, without any, where the maps come nearest to each other.
Pose Reframe(const FramePoses& from, const FramePoses& to, const std::vector<SubmapEdge>& edges,
             const Pose& T_a_b);

}  // namespace isthmus::matching
