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

// Points by viewpoint, two lists each of ascending indices: first the points in sight of it, then
// points that are in sight of no viewpoint and nearest to this one, so that none is lost. In sight
// are points within kSightM that no nearer one hides, one per 0.01 rad. A point hides as much as
// the map's points usually lie apart; one that stands alone (dust, a ghost) hides nothing and is in
// sight of none. `viewpoints` must not be empty; same frame as the points, which are finite.
std::vector<std::vector<uint32_t>> VisiblePoints(const Cloud& points, const Trajectory& viewpoints);

// Metres from the points to the viewpoint nearest to them, or any such distance within kSightM.
// Same frame.
double NearestM(const Cloud& points, const Trajectory& viewpoints);

}  // namespace isthmus::cli
