// The decision on a place that a robot may have come back to, from the hypotheses about it.
#pragma once

#include <vector>

#include "server/matching/loops/loop_options.h"
#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The first of `ranked`, best first, if it keeps all limits and no other is contradicted nearly as
// little; else null. Odometry says where the robot is about, so that limits are enough: where two
// robots' maps meet nothing does, and it takes a probability (pairs/decision.h).
const Hypothesis* ChooseLoop(const std::vector<Hypothesis>& ranked, const LoopOptions& options);

}  // namespace isthmus::matching
