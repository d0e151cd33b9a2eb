// Viewpoints of a finished map: where the sensor stood, and what it saw from there. A map on disk
// has lost them; matching needs them back, because what one robot saw to be free contradicts what a
// wrong match would put there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cloud.h"
#include "core/map/trajectory.h"

namespace isthmus::cli {

// Metres: how far a sensor sees, beyond which its points are sparse.
inline constexpr float kSightM = 40;

// The first pose, and every later one that is at least `distance_m` from the last one taken.
Trajectory Thin(const Trajectory& trajectory, double distance_m);

// For every viewpoint the indices, ascending, of the points in sight of it: within kSightM and not
// hidden by nearer ones, of which each covers `spacing_m`, the distance between the map's points;
// one per 0.01 rad. A point that is in sight of none is given to the nearest, so that none is lost.
// `viewpoints` must not be empty; same frame as the points.
std::vector<std::vector<uint32_t>> VisiblePoints(const Cloud& points, const Trajectory& viewpoints,
                                                 double spacing_m);

// Metres from the points to the viewpoint nearest to them, or any such distance within kSightM.
// Same frame.
double NearestM(const Cloud& points, const Trajectory& viewpoints);

}  // namespace isthmus::cli
