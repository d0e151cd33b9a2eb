// A session's scans in the map: odometry, bent to follow its submaps.
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/revision.h"
#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus::placement {

// The beginning of a submap in odom, and the correction that holds there.
struct TrajectoryKnot {
  uint32_t index = 0;
  int64_t stamp_ns = 0;  // Stamp of its first keyframe.
  Pose T_odom_submap;
};

// T_map_sensor of every entry. At the beginning of each submap the scan lies as the submap does;
// in between, by the share of the way gone, from the pose that one submap gives it to the pose that
// the next gives it; before the first and behind the last as that one says. Continuous, and rigid
// where the submaps did not move against each other. `knots` and `placement.submaps` in order of
// index; knots that are not placed are passed over. Without any: T_map_odom for all.
Trajectory CorrectTrajectory(const std::vector<TrajectoryEntry>& entries,
                             const std::vector<TrajectoryKnot>& knots, const Placement& placement);

}  // namespace isthmus::placement
