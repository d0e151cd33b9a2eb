// Tells what the points of a submap are of.
#pragma once

#include <vector>

#include "core/map/submap.h"
#include "server/composition/keep_on.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Sets label and certainty of the submap's thinned points; they depend on the submap alone. False
// when told to end.
bool LabelPoints(const Submap& submap, const KeepOn& keep_on, std::vector<WeightedPoint>* points);

}  // namespace isthmus::composition
