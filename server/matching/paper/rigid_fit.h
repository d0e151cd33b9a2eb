// The SVD step: the rigid transform that best takes one set of points to another.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/pose.h"

namespace isthmus::matching {

// Corresponding points of two maps.
struct PointPair {
  Eigen::Vector3f a, b;
};

// T_a_b that minimises the sum of |a - T_a_b b|^2: Umeyama, "Least-Squares Estimation of
// Transformation Parameters Between Two Point Patterns", PAMI 13, 1991, without scale. Never a
// reflection. Identity for no pairs; some minimiser where the points do not fix one.
Pose FitRigid(std::span<const PointPair> pairs);

}  // namespace isthmus::matching
