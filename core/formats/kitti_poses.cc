#include "core/formats/kitti_poses.h"

#include <absl/strings/str_format.h>

namespace isthmus::formats {

std::string FormatKittiPoses(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& stamped : trajectory) {
    const Eigen::Matrix3d R = stamped.pose.RotationMatrix();
    const Eigen::Vector3d& t = stamped.pose.translation();
    for (int row = 0; row < 3; ++row) {
      absl::StrAppendFormat(&text, "%.12g %.12g %.12g %.9g%s", R(row, 0), R(row, 1), R(row, 2),
                            t[row], row < 2 ? " " : "\n");
    }
  }
  return text;
}

}  // namespace isthmus::formats
