// The drives that would tell whether the maps of a pair that waits lie as a hypothesis has them: a
// map asks for what it lacks.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// For either robot the shortest drive after which the match would be accepted if a hypothesis is
// right; where none would be enough, the one after which it is the most probable. The better drive
// first; none of robots that find no way, or whose drives would tell little. `ranked`: the
// hypotheses of the match, the most probable first. Submaps are named by Submap::id.index.
std::vector<AskedDrive> AskForDrives(const PreparedMap& a, const PreparedMap& b,
                                     const std::vector<Hypothesis>& ranked,
                                     const MatcherOptions& options);

}  // namespace isthmus::matching
