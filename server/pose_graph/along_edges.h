// Poses of nodes that only edges tell of.
#pragma once

#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

// Gives each node without a pose (`has_pose`, as many as nodes) the one that edges add up to on the
// way to it: from nodes that have one, else from the lowest of its part of the graph, which is put
// at the origin. Edges between neighbouring nodes are followed first: those are odometry, and none
// of them is false.
void PlaceAlongEdges(std::vector<bool> has_pose, Problem& problem);

}  // namespace isthmus::pose_graph
