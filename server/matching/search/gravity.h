// The direction of gravity in a map, from its floors, ceilings and walls.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "server/matching/registration/surface.h"

namespace isthmus::matching {

// R_level_odom: the smallest rotation that takes the map's vertical to +z. The vertical minimises
// the squared sines of floors' and ceilings' normals to it and of walls' normals to the horizontal,
// reweighted while the gate narrows from `max_tilt_rad`; identity when too few surfaces lie within
// it. Assumes that odom's z is within `max_tilt_rad` of vertical.
Eigen::Quaterniond EstimateLevel(const std::vector<SurfacePoint>& surface,
                                 double max_tilt_rad = 0.3);

}  // namespace isthmus::matching
