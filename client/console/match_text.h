// A match for a person, as `graph`, `match` and `merge` print it.
#pragma once

#include <string>

#include "core/records/map_graph.h"

namespace isthmus::cli {

// The match, its reason and its numbers: several lines, each with its end. Numbers that were not
// computed are left out. `name` is what stands in front, "alice-1 ~ bob-1".
std::string MatchText(const MatchEdge& edge, const std::string& name);
std::string MatchText(const MatchEdge& edge);  // Named after its sessions.

}  // namespace isthmus::cli
