// The effective match of a pair: the computed one, as a person's decision changes it.
#pragma once

#include <optional>

#include "core/map/manual_decision.h"
#include "core/map/match.h"

namespace isthmus::match_graph {

// The match of a pair as the graph should see it. `computed` is absent where nothing was computed
// of the pair yet. An accepted or given transform carries the map before all computed ones
// (confidence 1); the numbers that were computed stay for the reader.
Match EffectiveMatch(const ManualDecision& manual_decision, const std::optional<Match>& computed);

}  // namespace isthmus::match_graph
