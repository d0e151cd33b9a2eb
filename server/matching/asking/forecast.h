// The figures of a hypothesis after a drive, if it is right.
#pragma once

#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The hypothesis as it would be measured if it is right and both robots had seen so many more
// square metres of the same ground: what is new agrees as each robot's own surfaces do, and tells
// as much per square metre as what they share.
Hypothesis Foresee(const Hypothesis& h, double new_m2);

}  // namespace isthmus::matching
