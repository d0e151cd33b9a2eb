#include "server/pose_graph/own_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "server/pose_graph/limits.h"

namespace isthmus::pose_graph {
namespace {

// Of the edges in doubt, at those poses; 0 for others.
std::vector<double> DoubtedChi2(const Problem& problem, const std::vector<Pose>& poses) {
  const Problem now{poses, {}, {}, {}};
  std::vector<double> chi2;
  for (const Edge& edge : problem.edges) {
    chi2.push_back(edge.may_be_wrong ? Chi2(now, edge) : 0);
  }
  return chi2;
}

// The weights that follow from a limit; whether any differs from what was found.
bool Judge(const std::vector<double>& chi2, double limit, const Result& result, Problem& problem) {
  bool changed = false;
  for (size_t i = 0; i < chi2.size(); ++i) {
    Edge& edge = problem.edges[i];
    if (!edge.may_be_wrong) continue;
    edge.weight = chi2[i] <= limit ? 1 : 0;
    changed = changed || edge.weight != result.edge_weights[i];
  }
  return changed;
}

}  // namespace

double VarianceScale(std::vector<double> chi2) {
  if (chi2.empty()) return 0;
  const auto quartile = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 4);
  std::nth_element(chi2.begin(), quartile, chi2.end());
  constexpr double kLowerQuartile = 3.45;  // Of chi-square with 6 degrees of freedom.
  return *quartile / kLowerQuartile;
}

absl::StatusOr<ScaledResult> OptimizeAtOwnScale(const Problem& problem, const Options& options) {
  absl::StatusOr<Result> first = Optimize(problem, options);
  if (!first.ok()) return first.status();
  ScaledResult scaled{*std::move(first)};
  const auto doubted = std::count_if(problem.edges.begin(), problem.edges.end(),
                                     [](const Edge& edge) { return edge.may_be_wrong; });
  if (doubted < kFewestToScale) return scaled;
  Problem judged = problem;
  Options scaled_options = options;
  scaled_options.go_on = true;
  for (int turn = 0; turn < kMaxScalings; ++turn) {
    const std::vector<double> chi2 = DoubtedChi2(problem, scaled.result.poses);
    std::vector<double> of_doubted;
    for (size_t i = 0; i < chi2.size(); ++i) {
      if (problem.edges[i].may_be_wrong) of_doubted.push_back(chi2[i]);
    }
    const double scale = std::max(1.0, kTailMargin * VarianceScale(std::move(of_doubted)));
    const double limit = options.doubt_chi2 * scale;
    if (!Judge(chi2, limit, scaled.result, judged)) return scaled;
    scaled_options.doubt_chi2 = limit;
    absl::StatusOr<Result> result = Optimize(judged, scaled_options);
    if (!result.ok()) return result.status();
    result->iterations += scaled.result.iterations;
    scaled = {*std::move(result), std::sqrt(scale)};
  }
  return scaled;
}

}  // namespace isthmus::pose_graph
