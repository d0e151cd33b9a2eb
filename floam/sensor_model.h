// What is known of a LiDAR model before it sends anything.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::floam {

struct SensorModel {
  std::string name;  // "vlp16"
  int rings = 0;     // Lasers.
  // Elevation of each ring, radians, ascending; for scans without a ring field.
  std::vector<double> elevations;
  double scan_period_s = 0.1;
  double min_range_m = 0.5;  // Nearer points are the robot itself or noise.
  double max_range_m = 100;
  // Azimuth of the first firing of a turn (radians, counter-clockwise from +x), and the sense of
  // rotation seen from above; for scans without a time field.
  double start_azimuth = 0;
  bool clockwise = true;
};

// Models known by name: vlp16, vlp32, hdl32, hdl64, os0-{32,64,128}, os1-..., os2-.... NotFound for
// any other, with the known names in the message.
absl::StatusOr<SensorModel> FindSensorModel(const std::string& name);
std::vector<std::string> SensorModelNames();

}  // namespace isthmus::floam
