// A pose for a person.
#pragma once

#include <absl/strings/str_format.h>

#include <string>

#include "core/pose.h"

namespace isthmus::cli {

// "x 1.204 y -3.310 z 0.012 m, turned 14.20 deg (yaw 14.18)".
inline std::string PoseText(const Pose& pose) {
  constexpr double kDegrees = 180 / 3.14159265358979323846;
  const Eigen::Vector3d& t = pose.translation();
  return absl::StrFormat("x %.3f y %.3f z %.3f m, turned %.2f deg (yaw %.2f)", t.x(), t.y(), t.z(),
                         RotationAngle(pose) * kDegrees, pose.Yaw() * kDegrees);
}

}  // namespace isthmus::cli
