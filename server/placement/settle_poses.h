// Results for readers, from a graph that was optimised.
#pragma once

#include <vector>

#include "server/placement/graph.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

// Sets poses back to those that readers have, where they differ by less than the options say.
void SettlePoses(const PlacerOptions& options, const std::vector<Placement>& previous,
                 Graph* graph);

Placement MakePlacement(const Session& session, const GraphSession& place, const Graph& graph);

// Edges that were passed over are not said to be discarded.
EdgeStatus EdgeStatusOf(const Input& input, const GraphSet& set);

}  // namespace isthmus::placement
