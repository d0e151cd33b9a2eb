#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

Vector6d EdgeError(const Pose& T_map_a, const Pose& T_map_b, const Pose& T_a_b) {
  return Log(T_map_a.Inverse() * T_map_b * T_a_b.Inverse());
}

Vector6d AnchorError(const Pose& T_map_node, const Pose& T_anchor) {
  Vector6d error;
  error << T_map_node.translation() - T_anchor.translation(),
      Log(Pose(T_map_node.rotation() * T_anchor.rotation().conjugate(), Eigen::Vector3d::Zero()))
          .tail<3>();
  return error;
}

double Chi2(const Problem& problem, const Edge& edge) {
  const Vector6d e = EdgeError(problem.poses[static_cast<size_t>(edge.a)],
                               problem.poses[static_cast<size_t>(edge.b)], edge.T_a_b);
  return e.dot(edge.information * e);
}

double Chi2(const Problem& problem, const Anchor& anchor) {
  const Vector6d e =
      AnchorError(problem.poses[static_cast<size_t>(anchor.node)], anchor.T_map_node);
  return e.dot(anchor.information * e);
}

}  // namespace isthmus::pose_graph
