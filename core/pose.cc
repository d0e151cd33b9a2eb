#include "core/pose.h"

#include <algorithm>
#include <cmath>

namespace isthmus {
namespace {

// Below this angle (rad) the closed forms lose digits and their series are exact to double.
constexpr double kSmallAngle = 1e-5;

}  // namespace

Pose Pose::FromMatrix(const Eigen::Matrix4d& matrix) {
  return Pose(Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>())),
              matrix.topRightCorner<3, 1>());
}

Pose Pose::FromXyzRpy(double x, double y, double z, double roll, double pitch, double yaw) {
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
  return Pose(rotation, Eigen::Vector3d(x, y, z));
}

Eigen::Matrix4d Pose::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = RotationMatrix();
  matrix.topRightCorner<3, 1>() = translation_;
  return matrix;
}

double Pose::Yaw() const {
  const Eigen::Vector3d x_axis = rotation_ * Eigen::Vector3d::UnitX();
  return std::atan2(x_axis.y(), x_axis.x());
}

Pose Pose::Inverse() const {
  const Eigen::Quaterniond inverse = rotation_.conjugate();
  return Pose(inverse, -(inverse * translation_));
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Pose Exp(const Vector6d& twist) {
  const Eigen::Vector3d rho = twist.head<3>();
  const Eigen::Vector3d phi = twist.tail<3>();
  const double angle = phi.norm();
  const Eigen::Matrix3d K = Skew(phi);
  double a = 0.5, b = 1.0 / 6.0, half_sinc = 0.5;  // (1 - cos)/x^2, (x - sin)/x^3, sin(x/2)/x
  if (angle > kSmallAngle) {
    half_sinc = std::sin(angle / 2) / angle;
    a = 2 * half_sinc * half_sinc;  // 1 - cos would lose all digits of a small angle.
    b = (angle - std::sin(angle)) / (angle * angle * angle);
  }
  const Eigen::Matrix3d V = Eigen::Matrix3d::Identity() + a * K + b * K * K;
  Eigen::Quaterniond q;
  q.w() = std::cos(angle / 2);
  q.vec() = half_sinc * phi;
  return Pose(q, V * rho);
}

Vector6d Log(const Pose& pose) {
  Eigen::Quaterniond q = pose.rotation();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double angle = 2 * std::atan2(sine, q.w());
  const Eigen::Vector3d phi = sine > kSmallAngle ? (angle / sine) * q.vec() : 2.0 * q.vec();
  double c = 1.0 / 12.0;
  if (angle > kSmallAngle) {
    // x sin(x) / (2 (1 - cos(x))) = x/2 cot(x/2), without the difference.
    c = (1 - angle / 2 / std::tan(angle / 2)) / (angle * angle);
  }
  const Eigen::Matrix3d K = Skew(phi);
  const Eigen::Matrix3d V_inverse = Eigen::Matrix3d::Identity() - 0.5 * K + c * K * K;
  Vector6d twist;
  twist << V_inverse * pose.translation(), phi;
  return twist;
}

Pose Interpolate(const Pose& from, const Pose& to, double fraction) {
  return from * Exp(fraction * Log(from.Inverse() * to));
}

double RotationAngle(const Pose& pose) {
  const double sine = pose.rotation().vec().norm();
  return 2 * std::atan2(sine, std::abs(pose.rotation().w()));
}

}  // namespace isthmus
