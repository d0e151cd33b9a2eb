#include "server/matching/search/planar_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace isthmus::matching {

std::vector<PlanarPose> SuppressNeighbors(std::vector<PlanarPose> poses,
                                          const Eigen::Vector2d& pivot, double radius_m,
                                          double yaw_rad, size_t limit) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& x, const auto& y) { return x.score > y.score; });
  const auto pivot_at = [&](const PlanarPose& p) -> Eigen::Vector2d {
    return Eigen::Rotation2Dd(p.yaw) * pivot + p.shift;
  };
  std::vector<PlanarPose> kept;
  for (const PlanarPose& pose : poses) {
    if (kept.size() >= limit) break;
    const Eigen::Vector2d at = pivot_at(pose);
    const bool shadowed = std::any_of(kept.begin(), kept.end(), [&](const PlanarPose& other) {
      const double turn = std::remainder(pose.yaw - other.yaw, 2 * M_PI);
      return std::abs(turn) < yaw_rad && (pivot_at(other) - at).norm() < radius_m;
    });
    if (!shadowed) kept.push_back(pose);
  }
  return kept;
}

}  // namespace isthmus::matching
