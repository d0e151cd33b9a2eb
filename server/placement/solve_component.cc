#include "server/placement/solve_component.h"

#include <algorithm>
#include <numeric>

#include "server/placement/initial_poses.h"
#include "server/placement/limits.h"
#include "server/pose_graph/limits.h"
#include "server/pose_graph/optimize_around.h"

namespace isthmus::placement {
namespace {

bool IsKept(double weight) { return weight >= 0.5; }

double CostOfAll(const pose_graph::Problem& problem) {
  double cost = 0;
  for (const pose_graph::Edge& edge : problem.edges) cost += Chi2(problem, edge);
  for (const pose_graph::Anchor& anchor : problem.anchors) cost += Chi2(problem, anchor);
  return cost;
}

double CostOfNew(const pose_graph::Problem& problem, const std::vector<int>& edges) {
  double cost = 0;
  for (const int i : edges) cost += Chi2(problem, problem.edges[static_cast<size_t>(i)]);
  return cost;
}

}  // namespace

Solved SolveComponent(const PlacerOptions& options, const GraphDiff& change, int partial_before,
                      Graph* graph) {
  Solved solved;
  pose_graph::Problem& problem = graph->problem;
  const bool all = change.anew || change.joined || change.new_anchor;
  // A graph without any error is already at its optimum.
  if (all ? CostOfAll(problem) <= kNothingCost
          : !change.loosened && CostOfNew(problem, change.edges) <= kNothingCost) {
    return solved;
  }
  solved.whole = all || problem.poses.size() <= options.whole_up_to ||
                 partial_before + 1 >= options.whole_after ||
                 change.edges.size() > options.whole_above_edges;
  solved.partial = !solved.whole;
  pose_graph::RegionOptions region;
  region.solver.max_seconds = options.max_seconds;
  region.position_tolerance_m = kRestM;
  region.rotation_tolerance_rad = kRestM / pose_graph::kLeverM;
  pose_graph::Options whole = region.solver;
  whole.go_on = !change.anew && !change.unknown;
  const auto result =
      solved.whole ? Optimize(problem, whole) : OptimizeAround(problem, change.edges, region);
  if (!result.ok()) {
    solved.converged = false;
    solved.trouble = std::string(result.status().message());
    return solved;
  }
  solved.converged = result->converged;
  problem.poses = result->poses;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    problem.edges[i].weight = IsKept(result->edge_weights[i]) ? 1 : 0;
  }
  for (size_t i = 0; i < problem.anchors.size(); ++i) {
    problem.anchors[i].weight = IsKept(result->anchor_weights[i]) ? 1 : 0;
  }
  return solved;
}

void ReturnDiscardedToTree(const Input& input, Graph* graph) {
  pose_graph::Problem& problem = graph->problem;
  std::vector<size_t> part(problem.poses.size());
  std::iota(part.begin(), part.end(), size_t{0});
  const auto find = [&part](int node) {
    size_t i = static_cast<size_t>(node);
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  bool any = false;
  for (const pose_graph::Edge& edge : problem.edges) {
    if (edge.weight == 0) any = true;
    if (edge.weight == 0) continue;
    const size_t a = find(edge.a), b = find(edge.b);
    part[std::max(a, b)] = std::min(a, b);
  }
  if (!any) return;
  std::vector<bool> held(part.size(), false), discarded(part.size(), false);
  held[find(graph->gauge)] = true;
  for (const pose_graph::Anchor& anchor : problem.anchors) {
    if (anchor.weight > 0) held[find(anchor.node)] = true;
  }
  for (const pose_graph::Edge& edge : problem.edges) {
    if (edge.weight == 0 && find(edge.a) != find(edge.b)) {
      discarded[find(edge.a)] = discarded[find(edge.b)] = true;
    }
  }
  for (size_t root = 0; root < part.size(); ++root) {
    if (find(static_cast<int>(root)) != root || held[root] || !discarded[root]) continue;
    const Pose T = TreePose(input, *graph, static_cast<int>(root)) * problem.poses[root].Inverse();
    for (size_t i = 0; i < part.size(); ++i) {
      if (find(static_cast<int>(i)) == root) problem.poses[i] = T * problem.poses[i];
    }
  }
}

}  // namespace isthmus::placement
