// Angles of a sensor's lasers, as makers give them for a unit.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/readers/packets/laser_geometry.h"

namespace isthmus::readers {

// Reads CSV: the number of the laser from 1 up, its elevation and azimuth in degrees (Hesai), or
// elevation and azimuth alone, in order (RoboSense). Lines that do not begin with a number, as the
// names of columns do, and empty ones are left out. InvalidArgument, naming what is wrong, where
// there are not `lasers` lines, one is not as the others, out of range, or given twice.
absl::StatusOr<Calibration> ParseAngles(const std::string& csv, int lasers);

}  // namespace isthmus::readers
