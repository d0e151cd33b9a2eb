// Poses of the submaps of two maps under a hypothesis.
#pragma once

#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"

namespace isthmus::matching {

// In a's odom frame, in order of the maps' submaps. Rigid: as each robot's odometry has them; after
// a joint refinement they have moved against it.
struct MapPoses {
  std::vector<Pose> a;  // T_a_submap of a's submaps.
  std::vector<Pose> b;  // T_a_submap of b's submaps.

  static MapPoses Rigid(const SessionMap& map_a, const SessionMap& map_b, const Pose& T_a_b) {
    MapPoses poses;
    for (const auto& submap : map_a.submaps) poses.a.push_back(submap->T_odom_submap);
    for (const auto& submap : map_b.submaps) poses.b.push_back(T_a_b * submap->T_odom_submap);
    return poses;
  }
};

}  // namespace isthmus::matching
