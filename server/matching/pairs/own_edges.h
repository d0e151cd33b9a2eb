// A session's own part in a joint refinement: its odometry and its loops.
#pragma once

#include <cstddef>
#include <vector>

#include "core/pose.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/pose_graph/problem.h"

namespace isthmus::matching {

// The submaps between the first and the last that an edge touches; the others follow them.
struct Range {
  size_t first = 0, last = 0;
  size_t count() const { return last - first + 1; }
};

// A session's knowledge of itself: steps of odometry and, behind them, its loops; nodes are
// positions.
struct OwnEdges {
  explicit OwnEdges(const PreparedMap& map);

  std::vector<Pose> best;  // Poses at which all of them agree best; empty without loops.
  std::vector<pose_graph::Edge> edges;
};

// The range with all that loops tie to it: what is outside follows it as a whole.
Range Close(const OwnEdges& own, Range range);

// Adds those within a closed range, which begins at `first_node`. Returns what they disagree by
// themselves.
double AddOwnEdges(const OwnEdges& own, const Range& range, int first_node,
                   std::vector<pose_graph::Edge>* edges);

}  // namespace isthmus::matching
