// Numbers about an alignment, whatever it was found by.
#pragma once

#include "server/matching/registration/refinable_map.h"

namespace isthmus::matching {

// Fills overlap, inliers, residual_m and information of `result` at result->T_a_b. A point of the
// map with fewer points lies on the other when it has a neighbour whose normal is within 60 degrees
// and which is within `distance_m`, along its normal, and within that or a voxel of the other map
// across. All stay at 0 without such points.
void MeasureAlignment(const RefinableMap::Data& a, const RefinableMap::Data& b, double distance_m,
                      Refinement* result);

}  // namespace isthmus::matching
