// A trajectory: the poses of a robot's sensor, scan by scan.
#pragma once

#include <cstdint>
#include <vector>

#include "core/pose.h"

namespace isthmus {

struct StampedPose {
  int64_t stamp_ns = 0;
  Pose pose;  // T_frame_sensor at the END of the scan; the frame is named by whoever holds it.
};

// One processed scan of a session.
struct TrajectoryEntry {
  uint64_t sequence = 0;
  int64_t stamp_ns = 0;  // END of the scan.
  Pose T_odom_sensor;
  uint32_t submap_index = 0;  // The submap this scan fell into.
};

using Trajectory = std::vector<StampedPose>;

}  // namespace isthmus
