// The least-squares problem behind GICP and VGICP: weighted pairs of points, one pose.
//
// Residual of a pair: d = q_a - T_a_b p_b; cost 1/2 sum of d^T W d. The pose is moved by a twist
// xi = [rho; phi] about a centre c in frame a:  T <- Trans(c) Exp(xi) Trans(-c) T.  Turning about a
// centre among the points keeps the problem well conditioned and nearly linear when the map lies
// far from the origin of a. The Jacobian is dd/dxi = -[I, -[T p_b - c]x].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace isthmus::matching {

struct Correspondence {
  Eigen::Vector3d p_b;
  Eigen::Vector3d q_a;
  Eigen::Matrix3d weight;  // W: information of the pair times its robust weight, frame a.
};

// 1/2 xi^T H xi + g^T xi + cost, the cost's second-order model (Gauss-Newton).
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0;
};

// Trans(c) Exp(xi) Trans(-c) T.
Pose MoveAbout(const Eigen::Vector3d& center, const Vector6d& twist, const Pose& T);

NormalEquations Linearize(const std::vector<Correspondence>& pairs, const Pose& T_a_b,
                          const Eigen::Vector3d& center);

// One damped Gauss-Newton step on fixed pairs: solves (H + damping diag(H)) xi = -g. Directions
// that the pairs say nothing about (a corridor's length) stay where they are. False, with T_a_b and
// twist unchanged, when there are fewer than 6 pairs or the result is not finite.
bool StepPose(const std::vector<Correspondence>& pairs, double damping, Pose* T_a_b,
              Vector6d* twist);

// True if a step moves less than `step_m`, and turns less than that over pose_graph::kLeverM.
bool IsSmallStep(const Vector6d& twist, double step_m);

// The information of a twist about the origin of frame a, given that of one about `center`.
Matrix6d MoveInformationToOrigin(const Matrix6d& information, const Eigen::Vector3d& center);

}  // namespace isthmus::matching
