// Placements of one level map on another during the bird's-eye search.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace isthmus::matching {

// A point p of b lies at Rz(yaw) p + shift in a's level frame.
struct PlanarPose {
  double yaw = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double score = 0;
};

// Keeps the best of placements that put b's `pivot` within `radius_m` and its heading within
// `yaw_rad` of each other; best first, at most `limit`.
std::vector<PlanarPose> SuppressNeighbors(std::vector<PlanarPose> poses,
                                          const Eigen::Vector2d& pivot, double radius_m,
                                          double yaw_rad, size_t limit);

}  // namespace isthmus::matching
