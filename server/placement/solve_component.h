// Poses of one component, from where the search begins.
#pragma once

#include <string>

#include "server/placement/graph.h"
#include "server/placement/graph_diff.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

struct Solved {
  bool whole = false;    // Everything was optimised, ...
  bool partial = false;  // ... or the surroundings of the changes. Neither: nothing had to be.
  bool converged = true;
  std::string trouble;
};

// Optimises problem.poses, and sets the weights of edges and anchors. `partial_before` of the
// optimisations since the last whole one were partial.
Solved SolveComponent(const PlacerOptions& options, const GraphDiff& change, int partial_before,
                      Graph* graph);

// Moves the parts that were joined to the rest only by matches that were all discarded back to
// where the spanning tree has them, without changing their shape.
void ReturnDiscardedToTree(const Input& input, Graph* graph);

}  // namespace isthmus::placement
