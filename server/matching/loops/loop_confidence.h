// The confidence in a loop closure, and its description.
#pragma once

#include "core/map/loop_closure.h"

namespace isthmus::matching {

// Fills confidence and detail from the other figures. Confidence is a logistic model's of
// contradiction, as a share of what is allowed, of comparisons and of overlap.
void DescribeLoop(double max_free_space, LoopClosure* closure);

}  // namespace isthmus::matching
