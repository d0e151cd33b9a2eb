// Necks between furniture, told from doors.
#pragma once

#include "core/floors/clutter.h"
#include "core/floors/distance.h"
#include "core/floors/necks.h"

namespace isthmus::floors {

// True if one of its ends is furniture, and no wall is in line with it.
bool IsBetweenFurniture(const Neck& neck, const Mask& ground, const Solids& solids,
                        double resolution_m);

}  // namespace isthmus::floors
