// The ground below a way through a world that somebody else has made, and what stands in it.
#pragma once

#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/wild/carrier.h"
#include "lab/simulation/wild/path.h"

namespace isthmus::simulation::wild {

// The path on the ground that a carrier comes to which follows it from its beginning: at most 0.35
// m up from step to step. As high as before where there is no ground.
Path OnGround(const Path& path, const Carrier& carrier, const RayCaster& world);

// `end_m`, or half a metre before the first place after `begin_m` where the carrier cannot go on:
// something other than leaves is in the way 0.3 or 0.8 m above ground, or hangs lower than the
// sensor and 2 m, or the ground ends or is steeper than 45 degrees. No less than `begin_m`.
double FreeUntil(const Path& path, double begin_m, double end_m, const Carrier& carrier,
                 const RayCaster& world);

}  // namespace isthmus::simulation::wild
