// Accepted matches checked against each other: going round a cycle of true ones leads back to where
// one began.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "server/match_graph/cycle_options.h"
#include "server/match_graph/match_graph.h"

namespace isthmus::match_graph {

// Fills cycle_m and cycle_deg of every match that may carry (else -1) by its best cycle: the one
// that leaves least, measured by what it is allowed to. Then, as long as a cycle disagrees, sets
// the odd ones out aside: state kAmbiguous, reason "CYCLE", a detail with the numbers. A cycle of
// more than four that disagrees although each match of it is in another one that agrees does not
// count: that is drift adding up.
//
// Which are they? A match given or accepted by hand (reason "BY_HAND") is taken to be true: never
// set aside, and one that contradicts nothing but such goes first. Of the others, that which has
// the smallest share of agreeing cycles among its cycles: a wrong match agrees with nothing, while
// the true ones round it agree with each other. Where several have about as small a share, as in a
// lone triangle, nothing tells which one is wrong but their confidence; if that is not clear
// either, all of them are set aside: a wrong merge destroys a map, a missed one costs a minute.
//
// `matches` are all there are; what was set aside for a disagreement that is gone comes back by
// itself, because every call begins anew. Deterministic: the order of nodes and matches does not
// matter. Thread safe (no shared state).
void CheckCycles(const std::vector<Node>& nodes, const CycleOptions& options,
                 std::vector<Match>* matches);

}  // namespace isthmus::match_graph
