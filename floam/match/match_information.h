// The information that matches give about a pose, freed from what their noise says and joined with
// prior knowledge.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"
#include "floam/match/match_sums.h"

namespace isthmus::floam {

// Prior knowledge of the pose: it is T_odom_sensor Exp(d), with this covariance of d.
struct PosePrior {
  Pose T_odom_sensor;
  Matrix6d covariance = Matrix6d::Identity();
};

// A covariance of twists that has no preferred direction.
Matrix6d Isotropic(double sigma_m, double sigma_rad);

// The minimum of matches, prior on the pose and prior on the twist together.
struct JointEstimate {
  Vector12d step = Vector12d::Zero();        // Step of [pose; twist] from where they are.
  Matrix12d covariance = Matrix12d::Zero();  // After it.
  // The information of the matches alone about the pose; of little information only the part that
  // is certain, which may be reported as known.
  Matrix6d match_information = Matrix6d::Zero();
};

// `sums`: those of `rows`, with all that is known of the twist added (which must make the twist's
// block regular); `offset` = Log(prior^-1 pose). In the eigenbasis of what the matches say,
// measured in the prior's standard deviations, what their noise says is taken off, and of what is
// little the share counts that does not hang on a few matches: a handful of points far away, or on
// something that moves, must not decide where the sensor is. The estimate uses that; said to be
// known is what matches tell whose normals lie along the motion (S. Tuna et al., "X-ICP", T-RO
// 2024, section V, likewise counts matches and leaves out those nearly at right angles).
JointEstimate Solve(const MatchSums& sums, const std::vector<MatchRow>& rows, const Matrix6d& prior,
                    const Vector6d& offset);

}  // namespace isthmus::floam
