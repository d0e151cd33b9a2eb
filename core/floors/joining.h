// Parts of rooms put together.
#pragma once

#include <cstdint>
#include <vector>

#include "core/floors/basins.h"
#include "core/floors/distance.h"

namespace isthmus::floors {

// Joins basins that only furniture parts, and small ones to what they hang together with. Basins
// that stay too small for a room get -1. The others are numbered anew by their first cells.
void JoinBasins(const Mask& ground, const std::vector<int32_t>& squares, double resolution_m,
                Basins* basins);

}  // namespace isthmus::floors
