// The terms of the pose graph as Ceres takes them; for .cc files of this folder only.
//
// A pose is a block of 7 numbers, [t; q] with q = (x, y, z, w), and moves by a twist on its right:
// T <- T Exp(delta). Errors are differentiated with respect to delta and then carried to the 7
// numbers by the manifold's MinusJacobian, so that Ceres, which multiplies by PlusJacobian, gets
// the 6 columns back exactly.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <array>

#include "core/pose.h"
#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

using PoseBlock = std::array<double, 7>;

PoseBlock ToBlock(const Pose& pose);
Pose FromBlock(const double* block);

class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  // x Exp(delta).
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;  // 7 x 6, row major.
  // Log(x^-1 y).
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;  // 6 x 7, row major.
};

// sqrt(weight) W e for an edge; with E = T_a^-1 T_b T_a_b^-1 = Exp(e),
//   de/d(delta_a) = -Jl(e)^-1,   de/d(delta_b) = Jl(e)^-1 Ad(T_a^-1 T_b).
class EdgeTerm : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  // `root` as of SquareRootInformation. `weight` is read at each evaluation and must outlive this.
  EdgeTerm(const Pose& T_a_b, const Matrix6d& root, const double* weight)
      : T_b_a_(T_a_b.Inverse()), root_(root), weight_(weight) {}
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override;

 private:
  Pose T_b_a_;
  Matrix6d root_;
  const double* weight_;
};

// sqrt(weight) W [d; phi] for an anchor; dd/d(delta) = [R, 0], dphi/d(delta) = [0, Jl(phi)^-1 R].
class AnchorTerm : public ceres::SizedCostFunction<6, 7> {
 public:
  AnchorTerm(const Pose& T_map_node, const Matrix6d& root, const double* weight)
      : T_map_node_(T_map_node), root_(root), weight_(weight) {}
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override;

 private:
  Pose T_map_node_;
  Matrix6d root_;
  const double* weight_;
};

}  // namespace isthmus::pose_graph
