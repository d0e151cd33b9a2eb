// Motions of a sensor that is not driven around: to measure what an odometry makes of them.
#pragma once

#include "core/pose.h"
#include "lab/simulation/route.h"

namespace isthmus::simulation {

Motion StandStill(const Pose& T_world_sensor);

// Stands still until `begin_s`; then turns about its own z axis, to the left for positive rates,
// reaching `yaw_rate_radps` after `ramp_s` > 0 seconds and keeping it for ever.
Motion SpinInPlace(const Pose& T_world_sensor, double yaw_rate_radps, double begin_s,
                   double ramp_s);

}  // namespace isthmus::simulation
