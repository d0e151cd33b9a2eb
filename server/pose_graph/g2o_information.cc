#include "server/pose_graph/g2o_information.h"

#include <array>
#include <cmath>

#include "core/geometry/se3.h"
#include "server/pose_graph/g2o.h"

namespace isthmus::pose_graph {
namespace {

// [t; q] of a small twist.
Matrix6d HalfTurns() {
  Vector6d scale;
  scale << 1, 1, 1, 0.5, 0.5, 0.5;
  return scale.asDiagonal();
}

constexpr std::array<int, 3> kInPlane = {0, 1, 5};  // x, y and the turn about z.

// The mean of the variances that `information` says; 0 where it says nothing along a direction.
double MeanPrecision(const Eigen::MatrixXd& information) {
  const double trace = information.inverse().trace();
  return std::isfinite(trace) && trace > 0 ? static_cast<double>(information.rows()) / trace : 0;
}

double SeSyncCost(const Pose& T_map_a, const Pose& T_map_b, const Edge& edge, const Matrix6d& g2o,
                  bool is_planar) {
  const Eigen::Matrix3d R_a = T_map_a.RotationMatrix();
  const double turn = (T_map_b.RotationMatrix() - R_a * edge.T_a_b.RotationMatrix()).squaredNorm();
  const double shift = (T_map_b.translation() - T_map_a * edge.T_a_b.translation()).squaredNorm();
  if (is_planar) {
    const Eigen::Matrix3d planar = ToPlanarInformation(g2o);
    return planar(2, 2) * turn + MeanPrecision(planar.topLeftCorner<2, 2>()) * shift;
  }
  return 0.5 * MeanPrecision(g2o.bottomRightCorner<3, 3>()) * turn +
         MeanPrecision(g2o.topLeftCorner<3, 3>()) * shift;
}

double G2oCost(const Pose& T_map_a, const Pose& T_map_b, const Edge& edge, const Matrix6d& g2o,
               bool is_planar) {
  const Pose gap = edge.T_a_b.Inverse() * T_map_a.Inverse() * T_map_b;
  if (is_planar) {
    const Eigen::Vector3d e(gap.translation().x(), gap.translation().y(), gap.Yaw());
    return e.dot(ToPlanarInformation(g2o) * e);
  }
  Vector6d e;
  e << gap.translation(), gap.rotation().vec() * (gap.rotation().w() < 0 ? -1 : 1);
  return e.dot(g2o * e);
}

}  // namespace

Matrix6d ToG2oInformation(const Matrix6d& information, const Pose& T_a_b) {
  // Our twist is Ad(M) times the one on the right, which is [t; 2 q].
  const Matrix6d A = Adjoint(T_a_b) * HalfTurns().inverse();
  return A.transpose() * information * A;
}

Matrix6d FromG2oInformation(const Matrix6d& g2o, const Pose& T_a_b) {
  const Matrix6d A = HalfTurns() * Adjoint(T_a_b.Inverse());
  return A.transpose() * g2o * A;
}

Matrix6d FromPlanarInformation(const Eigen::Matrix3d& planar) {
  const Eigen::Vector3d scale(1, 1, 2);  // The angle is twice q's z.
  Matrix6d g2o = Matrix6d::Zero();
  g2o(2, 2) = 0.5 * planar.topLeftCorner<2, 2>().trace();
  g2o(3, 3) = g2o(4, 4) = 4 * planar(2, 2);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      g2o(kInPlane[static_cast<size_t>(row)], kInPlane[static_cast<size_t>(column)]) =
          scale[row] * planar(row, column) * scale[column];
    }
  }
  return g2o;
}

Eigen::Matrix3d ToPlanarInformation(const Matrix6d& g2o) {
  const Eigen::Vector3d scale(1, 1, 0.5);
  Eigen::Matrix3d planar;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      planar(row, column) =
          scale[row] *
          g2o(kInPlane[static_cast<size_t>(row)], kInPlane[static_cast<size_t>(column)]) *
          scale[column];
    }
  }
  return planar;
}

PublicCosts CostsOfOthers(const Problem& problem, const std::vector<double>& weights,
                          bool is_planar) {
  PublicCosts costs;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    if (weights[i] == 0) continue;
    const Edge& edge = problem.edges[i];
    const Pose& T_map_a = problem.poses[static_cast<size_t>(edge.a)];
    const Pose& T_map_b = problem.poses[static_cast<size_t>(edge.b)];
    const Matrix6d g2o = ToG2oInformation(edge.information, edge.T_a_b);
    costs.g2o += weights[i] * G2oCost(T_map_a, T_map_b, edge, g2o, is_planar);
    costs.se_sync += weights[i] * SeSyncCost(T_map_a, T_map_b, edge, g2o, is_planar);
  }
  return costs;
}

}  // namespace isthmus::pose_graph
