// Derivatives on SE(3). A twist is [rho; phi]: translation first, rotation vector second, as
// core/pose.h has it. Barfoot, "State Estimation for Robotics" (2017), section 7.1.
#pragma once

#include <Eigen/Core>

#include "core/pose.h"

namespace isthmus {

// Ad(T) with T Exp(twist) = Exp(Ad(T) twist) T. Eq. 7.45.
Matrix6d Adjoint(const Pose& T);

// Log(Exp(d) Exp(phi)) = phi + J^-1 d + O(d^2), for rotation vectors. Angles below 2 pi. Eq. 7.77.
Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& phi);

// Log(Exp(d) Exp(twist)) = twist + J^-1 d + O(d^2). Rotation angles below 2 pi. Eq. 7.95.
Matrix6d InverseLeftJacobian(const Vector6d& twist);

}  // namespace isthmus
