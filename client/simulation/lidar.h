// When and where a simulated LiDAR's lasers fire during a turn.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::simulation {

// One measurement of a turn.
struct Firing {
  Eigen::Vector3f direction;  // Unit vector, sensor frame (x ahead, y left, z up).
  double time_s = 0;          // Since the beginning of the turn, in [0, period).
  uint16_t ring = 0;          // 0 = lowest elevation.
};

// A turn of the sensor: it begins looking straight back and goes clockwise seen from above, as
// Velodyne's and Ouster's do. Value type.
struct Lidar {
  std::string name;
  double period_s = 0.1;
  double min_range_m = 0.5;
  double max_range_m = 100;
  size_t lasers = 0;            // Firings come in groups of this size, one per ring.
  std::vector<Firing> firings;  // In order of time.
};

// Models:
//   vlp16   16 rings from -15 to 15 degrees; a group takes 55.296 us, a laser 2.304 us (manual,
//           Velodyne 63-9243), rings interleaved; 1808 groups in a turn at 10 Hz.
//   hdl32   32 rings from -30.67 to 10.67 degrees, 46.08 us, interleaved; 2170 groups.
//   hdl64   64 rings: 32 from 2 down to -8.33 in steps of 1/3 degree, 32 more down to -24.33 in
//           steps of 1/2 degree, 48 us, spread evenly; 2083 groups.
//   os1-64  64 rings from -22.5 to 22.5 degrees, all at once, 1024 groups.
// InvalidArgument, listing the names, for any other.
absl::StatusOr<Lidar> MakeLidar(const std::string& name);

std::vector<std::string> LidarNames();

}  // namespace isthmus::simulation
