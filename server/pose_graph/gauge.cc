#include "server/pose_graph/gauge.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/union_find.h"

namespace isthmus::pose_graph {
namespace {

// The least node connected with each node; `only_sure` does without doubtful edges.
std::vector<size_t> Components(const Problem& problem, bool only_sure) {
  const size_t n = problem.poses.size();
  UnionFind sets(n);
  for (const Edge& edge : problem.edges) {
    if (only_sure && edge.may_be_wrong) continue;
    sets.Unite(static_cast<size_t>(edge.a), static_cast<size_t>(edge.b));
  }
  std::vector<size_t> least(n, n), component(n);
  for (size_t i = 0; i < n; ++i) {
    size_t& of_set = least[sets.Find(i)];
    component[i] = of_set = std::min(of_set, i);
  }
  return component;
}

// True if anchors leave a rigid motion of all nodes no freedom. A motion [rho; phi] about the
// anchors' centre c changes [d; phi] of each by rho + phi x (t - c) and phi.
bool AreFixing(const std::vector<const Anchor*>& anchors) {
  if (anchors.empty()) return false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Anchor* anchor : anchors) center += anchor->T_map_node.translation();
  center /= static_cast<double>(anchors.size());
  Matrix6d information = Matrix6d::Zero();
  for (const Anchor* anchor : anchors) {
    Matrix6d J = Matrix6d::Identity();
    J.topRightCorner<3, 3>() = -Skew(anchor->T_map_node.translation() - center);
    information += J.transpose() * anchor->information * J;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() > 1e-6 * solver.eigenvalues().maxCoeff();
}

}  // namespace

Gauge ChooseGauge(const Problem& problem) {
  const size_t n = problem.poses.size();
  const std::vector<size_t> component = Components(problem, false);
  const std::vector<size_t> sure = Components(problem, true);
  std::vector<bool> has_anchor(n, false), held(n, false), sure_held(n, false);
  std::vector<std::vector<const Anchor*>> sure_anchors(n);
  for (const Anchor& anchor : problem.anchors) {
    const size_t node = static_cast<size_t>(anchor.node);
    has_anchor[component[node]] = true;
    if (!anchor.may_be_wrong) sure_anchors[sure[node]].push_back(&anchor);
  }
  std::vector<bool> fixed_component(n, false);
  for (const int fixed : problem.fixed) {
    held[static_cast<size_t>(fixed)] = true;
    fixed_component[component[static_cast<size_t>(fixed)]] = true;
  }
  for (size_t i = 0; i < n; ++i) {
    if (component[i] == i && !fixed_component[i] && !has_anchor[i]) held[i] = true;
  }
  for (size_t i = 0; i < n; ++i) {
    if (held[i]) sure_held[sure[i]] = true;
  }
  Gauge gauge;
  for (size_t i = 0; i < n; ++i) {
    if (held[i]) gauge.held.push_back(static_cast<int>(i));
    if (sure[i] == i && !sure_held[i] && !AreFixing(sure_anchors[i])) {
      gauge.steadied.push_back(static_cast<int>(i));
    }
  }
  return gauge;
}

}  // namespace isthmus::pose_graph
