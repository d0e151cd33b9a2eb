// Least squares over a pose and the motion within a scan, and what of it is noise of the normals.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace isthmus::floam {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

// Derivative of the distance n . (T q - m) to a plane of normal n (in the frame of T's target) by a
// small motion d = [rho; phi] of the pose, T -> T Exp(d): [n'; q x n'] with n' = R^T n.
inline Vector6d PoseJacobian(const Eigen::Vector3d& q, const Eigen::Vector3d& rotated_normal) {
  Vector6d jacobian;
  jacobian << rotated_normal, q.cross(rotated_normal);
  return jacobian;
}

// One match of a point to a plane, in the frame in which the pose moves: the sensor's.
struct MatchRow {
  Vector6d jacobian;  // Derivative of the residual by the pose, see PoseJacobian.
  double weight = 0, residual = 0;
  double tau = 0;  // Seconds from the pose's time to the point's.
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // From the middle of the plane's points to q.
  double tilt_variance = 0;                          // The normal's, per axis.
};

// Sums over all matches. The residuals are over x = [d; e]: a motion d of the pose and a change e
// of the twist within the scan. A point measured tau seconds after the pose's time moves by
// d + tau e, to first order in the motion within the scan (the left Jacobian of Exp(tau twist) is
// taken as identity), so its row is J = [a, tau a] with a = PoseJacobian.
//
// The normal n of a plane fitted to few or rough points is off by a small e, orthogonal to it, of
// variance s per axis; then E[(n + e)(n + e)^T] = n n^T + s (I - n n^T): along directions in which
// no plane holds it looks as if it were held, and an estimate that believes it stands still. After
// J. Hatleskog, K. Alexis, "Probabilistic Degeneracy Detection for Point-to-Plane Error
// Minimization", RA-L 2024, section III, where the noise of points and normals is carried into the
// Hessian.
struct MatchSums {
  Matrix12d information = Matrix12d::Zero();  // Sum w J^T J.
  Vector12d gradient = Vector12d::Zero();     // Sum w r J^T.
  // Sum w s B (I - n n^T) B^T with B = [I; [q]x]: what the noise alone would bring, ...
  Matrix6d noise = Matrix6d::Zero();
  // ... and with offset, where it draws the estimate to.
  Vector6d noise_gradient = Vector6d::Zero();
};

// Leaves the twist out (zeros) unless `with_twist`.
MatchSums SumOf(const std::vector<MatchRow>& rows, bool with_twist);

}  // namespace isthmus::floam
