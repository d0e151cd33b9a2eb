// A LiDAR model: what is known of a sensor before it sends anything.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::floam {

struct SensorModel {
  std::string name;  // "vlp16"
  // Else there are no rings, and times are what the scans say.
  bool spins = true;
  int rings = 0;  // Lasers; 0: not known before the first scan.
  // Elevation of each ring, radians, ascending; for scans without a ring field. Empty when the
  // scans are to show them.
  std::vector<double> elevations;
  double scan_period_s = 0.1;
  double min_range_m = 0.5;  // Nearer points are the robot itself or noise.
  double max_range_m = 100;
  // Azimuth of the first firing of a turn (radians, counter-clockwise from +x), and the sense of
  // rotation seen from above; for scans without a time field.
  double start_azimuth = 0;
  bool clockwise = true;
  // Files of this sensor hold ring after ring, each sorted by azimuth whatever the sense of turning
  // (KITTI): where points come ring by ring, their order tells nothing of time.
  bool sorted_files = false;
};

// Models known by name:
//   vlp16, vlp32, hdl32, hdl64, vls128, m8, os0-{32,64,128}, os1-..., os2-...: they spin.
//   spinning: nothing is known of it; rings and times come from the fields of its scans, else from
//     elevations and azimuths. Should its points not lie in rings, it is taken as one that does not
//     spin. Also called "auto" and "unknown".
//   solid, mid360, mid40, mid70, avia, horizon, tele15, and unordered for any other: they do not
//     spin, or are not to be taken to. Unordered is also called "any" and "livox".
// Case, '-', '_', ' ' and the name of the maker before it do not matter, nor does the letter after
// it (HDL-64E). NotFound for any other, with the known names in the message.
absl::StatusOr<SensorModel> FindSensorModel(const std::string& name);
std::vector<std::string> SensorModelNames();

}  // namespace isthmus::floam
