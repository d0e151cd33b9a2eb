#include "server/pose_graph/own_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "server/pose_graph/limits.h"

namespace isthmus::pose_graph {
namespace {

int64_t CountKept(const Problem& problem, const Result& result) {
  int64_t kept = 0;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    kept += problem.edges[i].may_be_wrong && result.edge_weights[i] >= 0.5 ? 1 : 0;
  }
  return kept;
}

}  // namespace

double VarianceScale(std::vector<double> chi2) {
  if (chi2.empty()) return 0;
  const auto quartile = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 4);
  std::nth_element(chi2.begin(), quartile, chi2.end());
  constexpr double kLowerQuartile = 3.45;  // For chi-square with 6 degrees of freedom.
  return *quartile / kLowerQuartile;
}

absl::StatusOr<ScaledResult> OptimizeAtOwnScale(const Problem& problem, const Options& options) {
  absl::StatusOr<Result> believed = Optimize(problem, options);
  if (!believed.ok()) return believed.status();
  const auto doubted = std::count_if(problem.edges.begin(), problem.edges.end(),
                                     [](const Edge& edge) { return edge.may_be_wrong; });
  ScaledResult first{*std::move(believed)};
  if (!options.judge || doubted < kFewestToScale) return first;
  Options larger = options;
  Problem next = problem;
  ScaledResult last = first;
  int64_t kept = CountKept(problem, first.result);
  for (int i = 1; i < kMostLimits && kept < doubted; ++i) {
    larger.doubt_chi2 *= kLimitGrowth;
    next.poses = last.result.poses;
    absl::StatusOr<Result> result = Optimize(next, larger);
    if (!result.ok()) return result.status();
    result->iterations += last.result.iterations;
    const int64_t now_kept = CountKept(problem, *result);
    const bool is_all =
        static_cast<double>(now_kept - kept) <= kFewFollow * static_cast<double>(kept);
    if (is_all && static_cast<double>(kept) >= kLeastRight * static_cast<double>(doubted)) {
      last.result.iterations = result->iterations;
      return last;
    }
    last = {*std::move(result), std::sqrt(larger.doubt_chi2 / options.doubt_chi2)};
    kept = now_kept;
  }
  if (kept == doubted) return last;
  first.result.iterations = last.result.iterations;
  return first;
}

}  // namespace isthmus::pose_graph
