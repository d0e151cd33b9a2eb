// The way of Ceres' own pose graph example: what a solver of a pose graph does when nobody thought
// about it, to compare with.
#pragma once

#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::bench {

struct ExampleResult {
  std::vector<Pose> poses;
  int iterations = 0;
};

// Position and quaternion as two blocks with Ceres' quaternion manifold, errors and Jacobians by
// automatic differentiation, sparse normal equations, 200 iterations, all else as Ceres has it. The
// first node is held. The error is that of pose_graph::Edge and the square root of its information
// the right way round, so that the sums compare. No edge is discarded.
ExampleResult SolveLikeCeresExample(const pose_graph::Problem& problem);

}  // namespace isthmus::bench
