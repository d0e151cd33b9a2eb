// Poses that are near each other.
#pragma once

#include "core/pose.h"

namespace isthmus {

// True if both are less than that apart, in metres and radians.
inline bool AreNear(const Pose& a, const Pose& b, double distance_m, double angle_rad) {
  const Pose T_a_b = a.Inverse() * b;
  return T_a_b.translation().norm() < distance_m && RotationAngle(T_a_b) < angle_rad;
}

}  // namespace isthmus
