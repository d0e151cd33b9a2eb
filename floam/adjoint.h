// How a small motion looks from another frame.
#pragma once

#include "core/pose.h"

namespace isthmus::floam {

// Ad(T) with T Exp(twist) = Exp(Ad(T) twist) T. Barfoot, "State Estimation for Robotics", eq. 7.45.
inline Matrix6d Adjoint(const Pose& T) {
  const Eigen::Matrix3d R = T.RotationMatrix();
  Matrix6d adjoint;
  adjoint << R, Skew(T.translation()) * R, Eigen::Matrix3d::Zero(), R;
  return adjoint;
}

}  // namespace isthmus::floam
