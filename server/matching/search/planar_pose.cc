#include "server/matching/search/planar_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace isthmus::matching {

Eigen::Vector2d PlanarPose::Apply(const Eigen::Vector2d& p) const {
  return Eigen::Rotation2Dd(yaw) * p + shift;
}

std::vector<PlanarPose> SuppressNeighbors(std::vector<PlanarPose> poses,
                                          const Eigen::Vector2d& pivot, double radius_m,
                                          double yaw_rad, size_t limit) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& x, const auto& y) { return x.score > y.score; });
  std::vector<PlanarPose> kept;
  for (const PlanarPose& pose : poses) {
    if (kept.size() >= limit) break;
    const Eigen::Vector2d at = pose.Apply(pivot);
    const bool shadowed = std::any_of(kept.begin(), kept.end(), [&](const PlanarPose& other) {
      const double turn = std::remainder(pose.yaw - other.yaw, 2 * M_PI);
      return std::abs(turn) < yaw_rad && (other.Apply(pivot) - at).norm() < radius_m;
    });
    if (!shadowed) kept.push_back(pose);
  }
  return kept;
}

PlanarPose Climb(PlanarPose pose, const Eigen::Vector2d& pivot, double yaw_step, double shift_step,
                 double smallest_m, const ScorePose& score) {
  while (shift_step > smallest_m) {
    bool better = false;
    for (int axis = 0; axis < 6; ++axis) {
      const double sign = axis % 2 ? -1 : 1;
      PlanarPose moved = pose;
      if (axis < 4) {
        moved.shift[axis / 2] += sign * shift_step;
      } else {  // About the pivot, so that yaw and shift do not fight.
        moved.yaw += sign * yaw_step;
        moved.shift = pose.Apply(pivot) - Eigen::Rotation2Dd(moved.yaw) * pivot;
      }
      moved.score = score(moved, pose.score);
      if (moved.score <= pose.score) continue;
      pose = moved;
      better = true;
    }
    if (better) continue;
    yaw_step *= 0.5;
    shift_step *= 0.5;
  }
  return pose;
}

}  // namespace isthmus::matching
