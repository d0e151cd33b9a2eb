#include "lab/simulation/manoeuvre.h"

#include <algorithm>

namespace isthmus::simulation {

Motion StandStill(const Pose& T_world_sensor) {
  return [T_world_sensor](double) { return T_world_sensor; };
}

Motion SpinInPlace(const Pose& T_world_sensor, double yaw_rate_radps, double begin_s,
                   double ramp_s) {
  return [=](double t) {
    const double since = std::max(0.0, t - begin_s);
    const double turning_s =
        since < ramp_s ? since * since / (2 * ramp_s) : since - ramp_s / 2;  // At full rate.
    return T_world_sensor * Pose::FromXyzRpy(0, 0, 0, 0, 0, yaw_rate_radps * turning_s);
  };
}

}  // namespace isthmus::simulation
