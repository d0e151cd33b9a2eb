// Rigid transforms on SE(3). A pose is named T_target_source: it takes the coordinates of a point
// in the source frame to the target frame. Metres and radians throughout.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace isthmus {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A rotation (unit quaternion, normalised on construction) and a translation. Value type; safe to
// read from many threads.
class Pose {
 public:
  Pose() = default;  // Identity.
  Pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation.normalized()), translation_(translation) {}
  explicit Pose(const Eigen::Vector3d& translation) : translation_(translation) {}

  // The rotation block is projected onto SO(3) by way of the quaternion.
  static Pose FromMatrix(const Eigen::Matrix4d& matrix);
  // Rotation R = Rz(yaw) Ry(pitch) Rx(roll).
  static Pose FromXyzRpy(double x, double y, double z, double roll, double pitch, double yaw);

  const Eigen::Quaterniond& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }
  Eigen::Matrix3d RotationMatrix() const { return rotation_.toRotationMatrix(); }
  Eigen::Matrix4d Matrix() const;
  // Angle of Rz in R = Rz Ry Rx, in (-pi, pi].
  double Yaw() const;

  Pose Inverse() const;
  bool IsFinite() const { return rotation_.coeffs().allFinite() && translation_.allFinite(); }

  friend Pose operator*(const Pose& T_a_b, const Pose& T_b_c) {
    return Pose(T_a_b.rotation_ * T_b_c.rotation_,
                T_a_b.translation_ + T_a_b.rotation_ * T_b_c.translation_);
  }
  friend Eigen::Vector3d operator*(const Pose& T_a_b, const Eigen::Vector3d& p_b) {
    return T_a_b.rotation_ * p_b + T_a_b.translation_;
  }

 private:
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

// The matrix [v]x with [v]x w = v x w.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

// Exponential map of a twist [rho; phi] (translation first, rotation vector second), with the full
// left Jacobian V(phi) rho as translation. Barfoot, "State Estimation for Robotics", eq. 7.86.
Pose Exp(const Vector6d& twist);
// Inverse of Exp for rotation angles below pi.
Vector6d Log(const Pose& pose);

// The pose on the geodesic from `from` (fraction 0) to `to` (fraction 1): from * Exp(f Log(from^-1
// to)). Extrapolates outside [0, 1].
Pose Interpolate(const Pose& from, const Pose& to, double fraction);

// Rotation angle of the pose in radians, in [0, pi].
double RotationAngle(const Pose& pose);

}  // namespace isthmus
