// A match for a person, as `graph`, `match` and `merge` print it.
#pragma once

#include <string>

#include "client/library/records.h"

namespace isthmus::cli {

// The match, its reason and its numbers: several lines, each with its end. Numbers that were not
// computed are left out. `name` is what stands in front, "alice-1 ~ bob-1".
std::string MatchText(const client::MatchEdge& edge, const std::string& name);
std::string MatchText(const client::MatchEdge& edge);  // Named after its sessions.

}  // namespace isthmus::cli
