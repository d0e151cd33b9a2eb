// The figures of a hypothesis after a drive, if it is right.
#pragma once

#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The hypothesis as it would be measured if it is right and the ground that both robots know well
// had grown by so large a share: what is new agrees as each robot's own surfaces do, and tells as
// much per square metre as what they share.
Hypothesis Foresee(const Hypothesis& h, double growth);

}  // namespace isthmus::matching
