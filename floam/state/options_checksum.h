// Tells whether a state was made with the settings at hand.
#pragma once

#include <cstdint>

#include "floam/odometry_options.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

// Over everything that the odometry's results depend on: all but undistort_cloud.
uint64_t OptionsChecksum(const SensorModel& sensor, const OdometryOptions& options);

}  // namespace isthmus::floam
