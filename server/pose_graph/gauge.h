// The gauge, which holds a pose graph in place. Edges only tell poses relative to each other: a
// connected component can be moved as a whole, by 6 degrees of freedom, and the cost stays the
// same. One node held still removes this freedom without bending anything.
#pragma once

#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

struct Gauge {
  // Ascending: the fixed nodes, and the lowest-numbered node of each connected component that has
  // neither a fixed node nor an anchor.
  std::vector<int> held;
  // Ascending, none of them held: the lowest-numbered node of each part that may come to have a
  // freedom left, by which it would wander: one that hangs on the rest by doubtful edges only, or
  // that has anchors, but doubtful or too few to hold it (one GNSS position says no heading). A
  // prior too weak to bend anything (a kilometre, a thousand radians) keeps it near its start.
  std::vector<int> steadied;
};

Gauge ChooseGauge(const Problem& problem);

}  // namespace isthmus::pose_graph
