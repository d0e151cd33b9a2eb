#include "server/pose_graph/drift_gate.h"

#include <Eigen/Cholesky>
#include <cstddef>

#include "core/geometry/se3.h"

namespace isthmus::pose_graph {
namespace {

// The uncertainty along directions of which an edge says nothing: a kilometre, a thousand radians.
constexpr double kLeastInformation = 1e-6;

Matrix6d Covariance(const Edge& edge) {
  const Matrix6d information = edge.information + kLeastInformation * Matrix6d::Identity();
  return information.ldlt().solve(Matrix6d::Identity());
}

// Trees of sure edges. `drift` is the covariance, collected from the root, of a twist about the
// origin of the map.
struct TreeNode {
  int parent = -1;
  int depth = 0;
  int tree = -1;
  Matrix6d drift = Matrix6d::Zero();
};

using Neighbours = std::vector<std::vector<const Edge*>>;

void Grow(const Problem& problem, const Neighbours& neighbours, int root,
          std::vector<TreeNode>* tree) {
  std::vector<int> open = {root};
  (*tree)[static_cast<size_t>(root)].tree = root;
  for (size_t next = 0; next < open.size(); ++next) {  // Breadth first: short ways.
    const int i = open[next];
    const TreeNode& from = (*tree)[static_cast<size_t>(i)];
    for (const Edge* edge : neighbours[static_cast<size_t>(i)]) {
      const int j = edge->a == i ? edge->b : edge->a;
      TreeNode& to = (*tree)[static_cast<size_t>(j)];
      if (to.tree >= 0) continue;
      const Matrix6d A = Adjoint(problem.poses[static_cast<size_t>(edge->a)]);
      to = {i, from.depth + 1, root, from.drift + A * Covariance(*edge) * A.transpose()};
      open.push_back(j);
    }
  }
}

std::vector<TreeNode> GrowAll(const Problem& problem) {
  Neighbours neighbours(problem.poses.size());
  for (const Edge& edge : problem.edges) {
    if (edge.may_be_wrong) continue;
    neighbours[static_cast<size_t>(edge.a)].push_back(&edge);
    neighbours[static_cast<size_t>(edge.b)].push_back(&edge);
  }
  std::vector<TreeNode> tree(problem.poses.size());
  for (size_t i = 0; i < tree.size(); ++i) {
    if (tree[i].tree < 0) Grow(problem, neighbours, static_cast<int>(i), &tree);
  }
  return tree;
}

int CommonAncestor(const std::vector<TreeNode>& tree, int a, int b) {
  while (a != b) {
    int& deeper = tree[static_cast<size_t>(a)].depth >= tree[static_cast<size_t>(b)].depth ? a : b;
    deeper = tree[static_cast<size_t>(deeper)].parent;
  }
  return a;
}

}  // namespace

std::vector<double> ChiSquareWithDrift(const Problem& problem) {
  const std::vector<TreeNode> tree = GrowAll(problem);
  std::vector<double> chi2(problem.edges.size(), 0);
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    const Edge& edge = problem.edges[i];
    const TreeNode& a = tree[static_cast<size_t>(edge.a)];
    const TreeNode& b = tree[static_cast<size_t>(edge.b)];
    if (!edge.may_be_wrong || a.tree != b.tree) continue;
    const int ancestor = CommonAncestor(tree, edge.a, edge.b);
    const Pose& T_map_a = problem.poses[static_cast<size_t>(edge.a)];
    const Pose& T_map_b = problem.poses[static_cast<size_t>(edge.b)];
    const Matrix6d A = Adjoint(T_map_a.Inverse());
    const Matrix6d drift = a.drift + b.drift - 2 * tree[static_cast<size_t>(ancestor)].drift;
    const Vector6d e = EdgeError(T_map_a, T_map_b, edge.T_a_b);
    const Matrix6d C = Covariance(edge) + A * drift * A.transpose();
    chi2[i] = e.dot(C.ldlt().solve(e));
  }
  return chi2;
}

}  // namespace isthmus::pose_graph
