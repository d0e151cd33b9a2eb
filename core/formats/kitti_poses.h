// Trajectories as KITTI's odometry benchmark has them: a line of twelve numbers per pose.
#pragma once

#include <string>

#include "core/map/trajectory.h"

namespace isthmus::formats {

// The upper three rows of T_frame_sensor, row by row, metres; stamps are not in the format. The
// sensor's axes stay ours (x ahead, z up), not those of KITTI's camera.
std::string FormatKittiPoses(const Trajectory& trajectory);

}  // namespace isthmus::formats
