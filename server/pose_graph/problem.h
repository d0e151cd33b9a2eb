// A pose graph: unknown poses, and the measurements of them.
#pragma once

#include <vector>

#include "core/pose.h"

namespace isthmus::pose_graph {

// Node b was seen from node a (odometry, a match, a closed loop). Its error is
//   e = Log(T_a^-1 T_b T_a_b^-1),  cost e^T information e,
// so `information` is of the twist [rho; phi] in the frame of a by which the true relative pose is
// Exp(twist) T_a_b; the same convention as SubmapEdge of core/map/match.h. It is symmetric and
// positive semi-definite; a direction without information (along a corridor) pulls nothing.
struct Edge {
  int a = 0;  // Indices into Problem::poses; not the same.
  int b = 0;
  Pose T_a_b;  // Takes a point of b's frame to a's.
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;  // To be doubted: graduated non-convexity may discard it.
  // The weight that an earlier optimisation gave a doubtful edge, from its Result::edge_weights;
  // only OptimizeAround looks at it, and Optimize when it is to go on from there.
  double weight = 1;
};

// A node's place in the map is known, or part of it. The error is decoupled, [d; phi] with
//   d = t - t_anchor  in the axes of the map,  R = Exp(phi) R_anchor,
// so that a GNSS position is one with a zero rotation block, whatever the node's heading is.
struct Anchor {
  int node = 0;
  Pose T_map_node;
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;
  double weight = 1;  // As of Edge.
};

struct Problem {
  std::vector<Pose> poses;  // T_map_node, where the search begins.
  std::vector<Edge> edges;
  std::vector<Anchor> anchors;
  std::vector<int> fixed;  // Nodes that stay where they are.
};

// The errors above.
Vector6d EdgeError(const Pose& T_map_a, const Pose& T_map_b, const Pose& T_a_b);
Vector6d AnchorError(const Pose& T_map_node, const Pose& T_anchor);

// e^T information e: for an edge that is right, distributed as chi-square of 6 degrees of freedom,
// or as many as the information has directions.
double Chi2(const Problem& problem, const Edge& edge);
double Chi2(const Problem& problem, const Anchor& anchor);

}  // namespace isthmus::pose_graph
