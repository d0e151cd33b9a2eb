// Least squares over a pose and the motion within a scan, accumulated residual by residual.
#pragma once

#include <Eigen/Core>

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

// Information matrix H and gradient g of sum w (r + J x)^2 over x = [d; e]: a motion d of the pose
// and a change e of the twist within the scan. A point measured tau seconds after the pose's time
// moves by d + tau e, to first order in the motion within the scan (the left Jacobian of
// Exp(tau twist) is taken as identity), so J = [a, tau a] with a = PoseJacobian. That is why the
// sums of w tau^k a a^T, k = 0, 1, 2, hold everything.
class NormalEquations {
 public:
  void Add(const Vector6d& a, double tau, double weight, double residual, bool with_twist) {
    const Vector6d wa = weight * a;
    pose_.noalias() += wa * a.transpose();
    pose_gradient_ += residual * wa;
    if (!with_twist) return;
    const Vector6d twa = tau * wa;
    mixed_.noalias() += twa * a.transpose();
    twist_.noalias() += (tau * twa) * a.transpose();
    twist_gradient_ += residual * twa;
  }

  const Matrix6d& pose() const { return pose_; }

  Matrix12d Information() const {
    Matrix12d information;
    information << pose_, mixed_, mixed_, twist_;
    return information;
  }
  Vector12d Gradient() const {
    Vector12d gradient;
    gradient << pose_gradient_, twist_gradient_;
    return gradient;
  }

 private:
  Matrix6d pose_ = Matrix6d::Zero(), mixed_ = Matrix6d::Zero(), twist_ = Matrix6d::Zero();
  Vector6d pose_gradient_ = Vector6d::Zero(), twist_gradient_ = Vector6d::Zero();
};

}  // namespace isthmus::floam
