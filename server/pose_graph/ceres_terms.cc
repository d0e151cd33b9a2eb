#include "server/pose_graph/ceres_terms.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"

namespace isthmus::pose_graph {
namespace {

using Matrix67 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;
using Matrix76 = Eigen::Matrix<double, 7, 6, Eigen::RowMajor>;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

// dq/d(phi) of q Exp(phi) at phi = 0, rows (x, y, z, w).
Eigen::Matrix<double, 4, 3> QuaternionJacobian(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> G;
  G.topRows<3>() = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + Skew(q.vec()));
  G.bottomRows<1>() = -0.5 * q.vec().transpose();
  return G;
}

Matrix67 MinusJacobianOf(const Pose& pose) {
  Matrix67 J = Matrix67::Zero();
  J.topLeftCorner<3, 3>() = pose.RotationMatrix().transpose();
  // 4 G^T is the left inverse of G, as the columns of G are orthogonal and half a unit long.
  J.bottomRightCorner<3, 4>() = 4 * QuaternionJacobian(pose.rotation()).transpose();
  return J;
}

void ChainJacobian(const Matrix6d& J, const Pose& pose, double* jacobian) {
  Eigen::Map<Matrix67>(jacobian).noalias() = J * MinusJacobianOf(pose);
}

}  // namespace

PoseBlock ToBlock(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Pose FromBlock(const double* block) {
  return Pose(Eigen::Quaterniond(block[6], block[3], block[4], block[5]),
              Eigen::Vector3d(block[0], block[1], block[2]));
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock block = ToBlock(FromBlock(x) * Exp(Eigen::Map<const Vector6d>(delta)));
  std::copy(block.begin(), block.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  const Pose pose = FromBlock(x);
  Eigen::Map<Matrix76> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>() = pose.RotationMatrix();
  J.bottomRightCorner<4, 3>() = QuaternionJacobian(pose.rotation());
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vector6d>{y_minus_x} = Log(FromBlock(x).Inverse() * FromBlock(y));
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Matrix67>{jacobian} = MinusJacobianOf(FromBlock(x));
  return true;
}

bool EdgeTerm::Evaluate(double const* const* blocks, double* residual, double** jacobians) const {
  const Pose T_map_a = FromBlock(blocks[0]), T_map_b = FromBlock(blocks[1]);
  const Pose T_a_b = T_map_a.Inverse() * T_map_b;
  const Vector6d e = Log(T_a_b * T_b_a_);
  const Matrix6d W = std::sqrt(*weight_) * root_;
  Eigen::Map<Vector6d>{residual} = W * e;
  if (jacobians == nullptr) return true;
  const Matrix6d WJ = W * InverseLeftJacobian(e);
  if (jacobians[0] != nullptr) ChainJacobian(-WJ, T_map_a, jacobians[0]);
  if (jacobians[1] != nullptr) ChainJacobian(WJ * Adjoint(T_a_b), T_map_b, jacobians[1]);
  return true;
}

bool AnchorTerm::Evaluate(double const* const* blocks, double* residual, double** jacobians) const {
  const Pose pose = FromBlock(blocks[0]);
  const Vector6d e = AnchorError(pose, T_map_node_);
  const Matrix6d W = std::sqrt(*weight_) * root_;
  Eigen::Map<Vector6d>{residual} = W * e;
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  const Eigen::Matrix3d R = pose.RotationMatrix();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = R;
  J.bottomRightCorner<3, 3>() = InverseLeftJacobian(Eigen::Vector3d(e.tail<3>())) * R;
  ChainJacobian(W * J, pose, jacobians[0]);
  return true;
}

}  // namespace isthmus::pose_graph
