// Graduated non-convexity with the truncated least-squares cost (Yang et al., RA-L 2020).
#pragma once

#include "absl/status/statusor.h"
#include "server/pose_graph/least_squares.h"

namespace isthmus::pose_graph {

// Eq. 14: the weight of an error with e^T information e = chi2, the truncation at `limit`. A small
// mu makes the cost convex, a large one truncates it sharply.
double GncWeight(double chi2, double limit, double mu);

struct GncOutcome {
  int iterations = 0;
  bool converged = false;
};

// Solves with weights 1, but for edges that contradict sure ones by more than drift explains
// (drift_gate.h). If that leaves doubtful edges or anchors above options.doubt_chi2, goes on from
// there, or from the start where more agree with that, with weights for a growing mu. In the end
// all weights are 0 or 1, and consistent: what counts is within the limit, what does not is beyond
// it, unless `converged` is false.
absl::StatusOr<GncOutcome> SolveWithGnc(const Problem& problem, const Options& options,
                                        LeastSquares* least_squares);

}  // namespace isthmus::pose_graph
