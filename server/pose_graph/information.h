// Information matrices: their square roots, and the information that odometry deserves.
#pragma once

#include "absl/status/statusor.h"
#include "core/pose.h"

namespace isthmus::pose_graph {

// W with W^T W = information, so that |W e|^2 = e^T information e. (With information = L L^T that
// is L^T; L would weigh errors along the wrong directions.) Directions without information become
// zero rows. InvalidArgument when the matrix is not finite, not symmetric, or negative along a
// direction, each by more than rounding explains.
absl::StatusOr<Matrix6d> SquareRootInformation(const Matrix6d& information);

// The drift of odometry between two submaps: one standard deviation per axis. The defaults suit a
// LiDAR odometry without loops that nobody has measured. The server's own strays by a tenth of it
// (17 mm in a lap of a campus), but its errors are not independent from submap to submap, as a
// chain of edges supposes, which the margin makes up for.
struct DriftModel {
  double position_m = 0.01;         // For any edge, however short.
  double position_per_m = 0.005;    // Per metre gone: 0.5 %.
  double rotation_rad = 0.00175;    // For any edge: 0.1 degrees.
  double rotation_per_m = 0.00035;  // Per metre gone: 0.02 degrees.
  double rotation_per_rad = 0.005;  // Per radian turned.

  friend bool operator==(const DriftModel&, const DriftModel&) = default;
};

// Information of an odometry edge in the convention of Edge. Turning errors are taken to happen
// half way between the nodes: a far node is also displaced by them. Distance and turn are those
// of T_a_b, or the ones given where the way was longer than its chord. Parameters below 1e-6 count
// as 1e-6, so that the result is always positive definite.
Matrix6d OdometryInformation(const Pose& T_a_b, const DriftModel& drift = {});
Matrix6d OdometryInformation(const Pose& T_a_b, double distance_m, double turn_rad,
                             const DriftModel& drift = {});

// The information of an edge that errs by `covariance`, too: the odometry's own word on its drift
// beside that of a model. Unchanged where that is zero, or no covariance.
Matrix6d AddCovariance(const Matrix6d& information, const Matrix6d& covariance);

}  // namespace isthmus::pose_graph
