// The figures of a hypothesis after a drive, if it is right.
#pragma once

#include "server/matching/asking/seen_ground.h"
#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The hypothesis as it would be measured if it is right and the driver had seen what is ahead,
// while both know `known_m2` well: of what the other robot saw there the driver sees kSeenAgain,
// and that agrees as each robot's own surfaces do.
Hypothesis Foresee(const Hypothesis& h, const Evidence& ahead, double known_m2);

}  // namespace isthmus::matching
