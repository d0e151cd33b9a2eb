// A sample of a surface: the points that an alignment is computed from.
#pragma once

#include <vector>

#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// Indices of at most `max_points` points, in ascending order: one per voxel of `voxel_m`, drawn
// evenly from the three classes of the largest component of the normal as far as they reach, so
// that ground and floors, often most of a map, do not drown the walls (normal-space sampling:
// Rusinkiewicz and Levoy, "Efficient Variants of the ICP Algorithm", 3DIM 2001). Deterministic.
std::vector<int> SampleBalanced(const std::vector<SurfacePoint>& points, double voxel_m,
                                size_t max_points);

}  // namespace isthmus::matching
