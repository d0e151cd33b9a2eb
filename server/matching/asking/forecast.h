// The figures of a hypothesis after a drive, if it is right.
#pragma once

#include "server/matching/asking/seen_ground.h"
#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The hypothesis as it would be measured if it is right and the driver had seen what is ahead,
// while both know `known_m2` well: what is new agrees as each robot's own surfaces do, and of what
// the other robot saw there the driver sees kSeenAgain.
Hypothesis Foresee(const Hypothesis& h, const Evidence& ahead, double known_m2);

}  // namespace isthmus::matching
