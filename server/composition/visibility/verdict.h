// The rule by which points of a submap leave the map.
#pragma once

#include <span>

#include "core/pose.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// Marks those that are gone: people, cars, a wall that was taken down.
//  1. The log odds of all looks say that it is all but certain. Where it takes looks through from
//  before it was seen to say so, it may have come since: it stays if its points and those around
//  them that came like them are seen for a while, some of them twice, and rather than looked
//  through.
//  2. It was seen at about one moment only, stands above the ground, and is near what is gone by
//  the first rule and was seen at that moment. Of feet no look can tell whether it went through
//  them, because the ground behind is as near. Likewise what is near that, twice, unless looks say
//  that it is there.
void MarkGone(std::span<WeightedPoint> points, const Pose& T_map_submap);

}  // namespace isthmus::composition
