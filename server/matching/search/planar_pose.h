// Placements of one level map on another, seen from above.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace isthmus::matching {

// A point p of b lies at Rz(yaw) p + shift in a's level frame.
struct PlanarPose {
  double yaw = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double score = 0;

  Eigen::Vector2d Apply(const Eigen::Vector2d& p) const;
};

// Keeps the best of placements that put b's `pivot` within `radius_m` and its heading within
// `yaw_rad` of each other; best first, at most `limit`.
std::vector<PlanarPose> SuppressNeighbors(std::vector<PlanarPose> poses,
                                          const Eigen::Vector2d& pivot, double radius_m,
                                          double yaw_rad, size_t limit);

// Hill climbing from `pose`, whose score is set, on yaw, x and y about b's `pivot`, with steps that
// are halved until those of the shift are no longer than `smallest_m`. `score` may end early, with
// any number up to `least`, where the score is no more than that.
using ScorePose = std::function<double(const PlanarPose& pose, double least)>;
PlanarPose Climb(PlanarPose pose, const Eigen::Vector2d& pivot, double yaw_step, double shift_step,
                 double smallest_m, const ScorePose& score);

}  // namespace isthmus::matching
