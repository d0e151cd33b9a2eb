// Numbers about an alignment, whatever it was found by.
#pragma once

#include "server/matching/refinable_map.h"

namespace isthmus::matching {

// Fills overlap, inliers, residual_m and information of `result` at result->T_a_b. A point of the
// map with fewer points lies on the other when it has a neighbour within `distance_m` whose normal
// is within 60 degrees. All stay at 0 without such points.
void MeasureAlignment(const RefinableMap::Data& a, const RefinableMap::Data& b, double distance_m,
                      Refinement* result);

}  // namespace isthmus::matching
