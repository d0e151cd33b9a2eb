#include "core/geometry/se3.h"

#include <cmath>

namespace isthmus {
namespace {

// sum over k of (-1)^k x^2k / (2k + n)!: what is left of a sine or cosine, divided by x^n, once its
// first terms are taken away. The closed forms lose all digits at small angles.
double Remainder(double x, int n) {
  double factorial = 1;
  for (int i = 2; i <= n; ++i) factorial *= i;
  double term = 1 / factorial, sum = term;
  for (int k = 1; k <= 24 && std::abs(term) > 1e-18 * std::abs(sum); ++k) {
    term *= -x * x / ((2 * k + n - 1) * (2 * k + n));
    sum += term;
  }
  return sum;
}

// The upper right block of the left Jacobian, eq. 7.86b.
Eigen::Matrix3d Coupling(const Vector6d& twist) {
  const Eigen::Matrix3d P = Skew(twist.head<3>());
  const Eigen::Matrix3d K = Skew(twist.tail<3>());
  const double x = twist.tail<3>().norm();
  const double c3 = Remainder(x, 3);                   // (x - sin x) / x^3
  const double c4 = Remainder(x, 4);                   // (x^2/2 + cos x - 1) / x^4
  const double c5 = 0.5 * (c4 - 3 * Remainder(x, 5));  // (2x - 3 sin x + x cos x) / 2x^5
  const Eigen::Matrix3d KP = K * P, PK = P * K, KPK = KP * K;
  return 0.5 * P + c3 * (KP + PK + KPK) + c4 * (K * KP + PK * K - 3 * KPK) +
         c5 * (KPK * K + K * KPK);
}

Matrix6d Blocks(const Eigen::Matrix3d& diagonal, const Eigen::Matrix3d& upper) {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = diagonal;
  m.bottomRightCorner<3, 3>() = diagonal;
  m.topRightCorner<3, 3>() = upper;
  return m;
}

}  // namespace

Matrix6d Adjoint(const Pose& T) {
  const Eigen::Matrix3d R = T.RotationMatrix();
  return Blocks(R, Skew(T.translation()) * R);
}

Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& phi) {
  const double x = phi.norm();
  const Eigen::Matrix3d K = Skew(phi);
  // (1 - x/2 cot(x/2)) / x^2
  const double c = x > 1e-5 ? (1 - x / 2 / std::tan(x / 2)) / (x * x) : 1.0 / 12;
  return Eigen::Matrix3d::Identity() - 0.5 * K + c * K * K;
}

Matrix6d InverseLeftJacobian(const Vector6d& twist) {
  const Eigen::Matrix3d inverse = InverseLeftJacobian(Eigen::Vector3d(twist.tail<3>()));
  return Blocks(inverse, -inverse * Coupling(twist) * inverse);
}

}  // namespace isthmus
