// The confidence in a loop closure, and its description.
#pragma once

#include <string>

#include "core/map/loop_closure.h"

namespace isthmus::matching {

// Fills confidence and detail from the other figures. Confidence is a logistic model's of
// contradiction, as a share of what is allowed, of comparisons and of overlap. The detail begins
// with `event`, which says what was found.
void DescribeLoop(double max_free_space, const std::string& event, LoopClosure* closure);

// The event of a robot that came back.
std::string CameBack(const LoopClosure& closure);

}  // namespace isthmus::matching
