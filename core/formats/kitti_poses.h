// Trajectories of KITTI's benchmark of odometry: the upper three rows of a 4 x 4 matrix per line.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "core/map/trajectory.h"
#include "core/pose.h"

namespace isthmus::formats {

// Twelve numbers per line, row by row, without stamps. Rotations are made orthonormal, as such
// files keep six digits. InvalidArgument, naming the line, for anything else and for a matrix that
// is no rotation. Lines that start with # and empty lines are skipped.
absl::StatusOr<std::vector<Pose>> ParseKittiPoses(const std::string& text);

// True if the first line that is no comment has twelve values: a TUM file has eight.
bool LooksLikeKittiPoses(const std::string& text);

// T_frame_sensor of a trajectory in such lines; stamps are not in the format. The sensor's axes
// stay ours (x ahead, z up), not those of KITTI's camera.
std::string FormatKittiPoses(const Trajectory& trajectory);

}  // namespace isthmus::formats
