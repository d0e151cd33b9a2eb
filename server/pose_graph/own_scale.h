// The scale of a pose graph's errors, told by the edges themselves where their sigmas are too
// small.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::pose_graph {

// The ratio of the lower quartile of `chi2` to that of errors whose information is
// honest (chi-square, 6 degrees of freedom): of variances, not sigmas. Right as long as no more
// than three in four are false. 0 for none.
double VarianceScale(std::vector<double> chi2);

struct ScaledResult {
  Result result;
  double sigma_scale = 1;  // Sigmas were taken to be so many times larger when edges were judged.
};

// Optimize, but edges in doubt are judged by the scale of their own errors where that is larger
// than their information says: odometry and loops of real recordings often stray by several times
// the sigma that a program wrote. Tries ever larger limits until the next keeps hardly any edge
// more. Where that does not come, or fewer than kFewestToScale are in doubt, their information is
// believed. Errors as Optimize.
absl::StatusOr<ScaledResult> OptimizeAtOwnScale(const Problem& problem, const Options& options);

}  // namespace isthmus::pose_graph
