// A component's pose graph for other programs.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/placement/graph.h"

namespace isthmus::placement {

// g2o's text (pose_graph/g2o.h), without what was discarded, after a comment line for every vertex:
// "# VERTEX 12 alice-1/7".
absl::StatusOr<std::string> GraphText(const Graph& graph);

}  // namespace isthmus::placement
