#include "server/matching/search/placement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace isthmus::matching {

std::vector<Placement2d> SuppressNeighbors(std::vector<Placement2d> placements,
                                           const Eigen::Vector2d& pivot, double radius_m,
                                           double yaw_rad, size_t limit) {
  std::stable_sort(placements.begin(), placements.end(),
                   [](const auto& x, const auto& y) { return x.score > y.score; });
  const auto pivot_at = [&](const Placement2d& p) -> Eigen::Vector2d {
    return Eigen::Rotation2Dd(p.yaw) * pivot + p.shift;
  };
  std::vector<Placement2d> kept;
  for (const Placement2d& placement : placements) {
    if (kept.size() >= limit) break;
    const Eigen::Vector2d at = pivot_at(placement);
    const bool shadowed = std::any_of(kept.begin(), kept.end(), [&](const Placement2d& other) {
      const double turn = std::remainder(placement.yaw - other.yaw, 2 * M_PI);
      return std::abs(turn) < yaw_rad && (pivot_at(other) - at).norm() < radius_m;
    });
    if (!shadowed) kept.push_back(placement);
  }
  return kept;
}

}  // namespace isthmus::matching
