// The way by which two sessions lie in one map, if they do.
#pragma once

#include <optional>
#include <vector>

#include "core/records/map_graph.h"

namespace isthmus::cli {

// The sessions between the two along the matches that carry the map; none where they are matched
// with each other. Absent where the two lie in different maps, or one in none.
std::optional<std::vector<SessionId>> WayBetween(const MatchGraph& graph, const SessionId& a,
                                                 const SessionId& b);

}  // namespace isthmus::cli
