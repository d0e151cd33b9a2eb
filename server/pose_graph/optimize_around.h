// Local optimisation: the poses around new edges, at a cost that grows with their effect.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::pose_graph {

struct RegionOptions {
  Options solver = {};
  int neighbourhood = 3;  // Edges from the cycles of the new edges that move from the start.
  double position_tolerance_m = 5e-4;    // A held node that wants to move by more is let go, ...
  double rotation_tolerance_rad = 5e-5;  // ... by more than either.
  int max_growths = 30;                  // After which everything is free.
};

// Poses of `problem` after new edges, whose indices are given, when its other poses were optimal
// without them: as Optimize, but only nodes in a region move.
//
// The region begins with the new edges, the shortest ways between their ends by the other edges
// (the cycles they close), and what is near those. It is solved with all other nodes held. Then
// each held node beside it says how far it alone would go (its own Newton step). Those that would
// go farther than the tolerance join, with their neighbours, and it is solved again. Parts without
// cycles, gauge or anchors that hang on the rest by one edge follow it rigidly.
//
// Guaranteed: every node is where it is best by itself, to within the tolerance, all others given;
// the nodes of the region are best jointly. Neighbours then lie to each other as Optimize would
// place them, to about a millimetre. Not guaranteed: that all positions are as near to Optimize's.
// What is beyond the region keeps its heading; a turn by 5e-5 rad, too little for any node to want
// it, moves the far end of a map of 500 m by 2 cm. Optimise everything now and then.
//
// Doubtful edges and anchors with a weight below 0.5 (from the last Result) are left out: only
// Optimize looks at them again. The rest of the doubtful in the region is judged anew; those
// outside keep their weight. Chi2 in the result is of the region's edges; `held` are the gauge's
// nodes and `free_nodes` counts the region's. InvalidArgument also when a new edge does not exist.
absl::StatusOr<Result> OptimizeAround(const Problem& problem, const std::vector<int>& new_edges,
                                      const RegionOptions& options = {});

}  // namespace isthmus::pose_graph
