// Further places where the ways of two joined sessions meet: the way from one along an edge that
// joins them to the other is searched for loops as that of one robot would be.
#pragma once

#include <stop_token>

#include "server/matching/loops/loop_options.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// Two maps that drifted are aligned where they were found to meet; wherever else they come near
// each other they may lie metres off. There the submaps that were never asked (`joined`.meetings)
// are laid on those of the other map as far as both odometries may have strayed, and verified as
// loops are (CloseLoop). `joined` is an accepted hypothesis about the maps. Found are edges that it
// does not have. Deterministic. Thread safe.
Meetings FindMeetings(const PreparedMap& a, const PreparedMap& b, const Hypothesis& joined,
                      const LoopOptions& options, const std::stop_token& stop = {});

}  // namespace isthmus::matching
