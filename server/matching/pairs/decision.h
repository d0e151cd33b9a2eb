// The decision on a pair of maps, from the hypotheses about it.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/pairs/matcher_options.h"

namespace isthmus::matching {

// Fills everything of `match` that follows from the hypotheses, the most probable first: state,
// reason, detail, transform and all figures.
void DecideState(const std::vector<Hypothesis>& ranked, const MatcherOptions& options,
                 Match* match);

}  // namespace isthmus::matching
