#include "server/pose_graph/optimize.h"

#include "server/pose_graph/gauge.h"
#include "server/pose_graph/gnc.h"
#include "server/pose_graph/least_squares.h"
#include "server/pose_graph/validate.h"

namespace isthmus::pose_graph {
namespace {

double TotalChi2(const Problem& problem, const std::vector<Pose>& poses, const Weights& weights) {
  const Problem now{poses, {}, {}, {}};
  double total = 0;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    if (weights.edges[i] > 0) total += weights.edges[i] * Chi2(now, problem.edges[i]);
  }
  for (size_t i = 0; i < problem.anchors.size(); ++i) {
    if (weights.anchors[i] > 0) total += weights.anchors[i] * Chi2(now, problem.anchors[i]);
  }
  return total;
}

}  // namespace

absl::StatusOr<Result> Optimize(const Problem& problem, const Options& options) {
  const absl::Status valid = Validate(problem, options);
  if (!valid.ok()) return valid;
  Result result;
  const Gauge gauge = ChooseGauge(problem);
  auto least_squares = LeastSquares::Create(problem, gauge);
  if (!least_squares.ok()) return least_squares.status();
  result.initial_chi2 = TotalChi2(problem, problem.poses, (*least_squares)->weights());

  const auto outcome = SolveWithGnc(problem, options, least_squares->get());
  if (!outcome.ok()) return outcome.status();
  result.iterations = outcome->iterations;
  result.converged = outcome->converged;
  result.poses = (*least_squares)->poses();
  for (const int held : gauge.held) {  // To the last bit.
    result.poses[static_cast<size_t>(held)] = problem.poses[static_cast<size_t>(held)];
  }
  const Weights& weights = (*least_squares)->weights();
  result.edge_weights = weights.edges;
  result.anchor_weights = weights.anchors;
  result.final_chi2 = TotalChi2(problem, result.poses, weights);
  result.held = gauge.held;
  result.free_nodes = static_cast<int>(problem.poses.size() - gauge.held.size());
  return result;
}

}  // namespace isthmus::pose_graph
