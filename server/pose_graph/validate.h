// Validation of a problem before it is handed to the solver.
#pragma once

#include "absl/status/status.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::pose_graph {

// Everything that Optimize promises to refuse, but for the definiteness of information matrices.
absl::Status Validate(const Problem& problem, const Options& options);

}  // namespace isthmus::pose_graph
