// The uncertainty of a session's older submaps relative to its newest, along its odometry and
// across the loops that are closed already.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"
#include "server/pose_graph/information.h"

namespace isthmus::matching {

// An edge of a closed loop. Positions are of the vector of submaps.
struct LoopEdge {
  size_t a = 0, b = 0;
  Pose T_a_b;
  Matrix6d information = Matrix6d::Zero();  // As in SubmapEdge.
};

struct KnownPose {
  Pose T_new_old;
  // The covariance of the twist [rho; phi] in the new submap's frame by which the truth is
  // Exp(twist) T_new_old.
  Matrix6d covariance = Matrix6d::Zero();

  // Standard deviation of a point, given in the new submap's frame, along the worst direction; and
  // of the rotation about the worst axis.
  double PositionSigma(const Eigen::Vector3d& point) const;
  double RotationSigma() const;
  // e^T C^-1 e of the error e that this pose makes if the truth is `T_new_old`, where C also has
  // room for an error of the truth itself, by `slack_m` and `slack_rad` (standard deviations) at
  // `point`.
  double Chi2(const Pose& true_T_new_old, const Eigen::Vector3d& point, double slack_m,
              double slack_rad) const;
};

// The pose of every submap before the last, by the path of least variance (Dijkstra, 10 m of lever
// between rotation and position). Odometry strays as `drift` says over the `path_lengths` travelled
// (of each submap, since some point), and by what the submaps say themselves on top of it. O(n log
// n), some microseconds each.
std::vector<KnownPose> LookBack(const std::vector<std::shared_ptr<const Submap>>& submaps,
                                const std::vector<double>& path_lengths,
                                const std::vector<LoopEdge>& edges,
                                const pose_graph::DriftModel& drift);

}  // namespace isthmus::matching
