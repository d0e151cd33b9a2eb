// Doubtful edges that contradict sure edges by more than their drift explains.
#pragma once

#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

// For each edge, e^T C^-1 e of its error at problem.poses, where C is the covariance of the edge
// and of the sure edges on the way from a to b, along a tree of them, to first order. This is what
// believing the edge alone costs in total, if the poses are those that sure edges give; an edge
// that closes a long loop may have a large error and still agree. 0 for edges that are not in doubt
// and for those whose ends no sure edges connect.
//
// False edges between far apart nodes show before anything is solved. That saves more than their
// errors: each of them ties distant rows of a sparse system together, and with a few hundred of
// them it is practically dense. Takes time O(nodes + edges).
std::vector<double> ChiSquareWithDrift(const Problem& problem);

}  // namespace isthmus::pose_graph
