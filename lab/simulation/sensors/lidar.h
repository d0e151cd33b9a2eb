// A simulated LiDAR: when and in which direction its lasers fire during a scan.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::simulation {

// One measurement of a scan.
struct Firing {
  Eigen::Vector3f direction;  // Unit vector, sensor frame (x ahead, y left, z up).
  double time_s = 0;          // Since the beginning of the scan, in [0, period).
  uint16_t ring = 0;          // 0 = lowest elevation; 0 for all where there are no rings.
};

// A scan of the sensor. One that spins begins looking straight back and goes clockwise seen from
// above, as Velodyne's and Ouster's do. Value type.
struct Lidar {
  std::string name;
  double period_s = 0.1;
  double min_range_m = 0.5;
  double max_range_m = 100;
  bool has_rings = true;  // It spins.
  // Firings come in groups of this size, evenly spread over the period: one per ring if there are
  // rings, else all of a tenth of a millisecond.
  size_t lasers = 0;
  std::vector<Firing> firings;  // The first scan's, in order of time.
  // From scan to scan all directions are turned by this (rotation vector, sensor frame): zero for a
  // pattern that repeats.
  Eigen::Vector3d turn_per_scan = Eigen::Vector3d::Zero();
};

// The rotation of all directions in the index-th scan, counted from 0.
Eigen::Matrix3f TurnOfScan(const Lidar& lidar, int index);
// The sensor with the firings of that scan.
Lidar AtScan(Lidar lidar, int index);

// Models that spin, at 10 Hz, their rings interleaved in time but for Ouster's, which all fire at
// once:
//   vlp16        16 rings from -15 to 15 degrees; a group takes 55.296 us, a laser 2.304 us
//                (manual, Velodyne 63-9243); 1808 groups in a turn.
//   vlp32        32 rings from -25 to 15 degrees, closest around the horizon, in the order and by
//                the angles of the VLP-32C's manual, two at a time, 55.296 us; 200 m.
//   hdl32        32 rings from -30.67 to 10.67 degrees, 46.08 us; 2170 groups.
//   hdl64        64 rings: 32 from 2 down to -8.33 in steps of 1/3 degree, 32 more down to -24.33
//                in steps of 1/2 degree, 48 us, spread evenly; 2083 groups; 120 m.
//   vls128       128 rings from -25 to 15 degrees, evenly spaced, 53.3 us; 1876 groups; 220 m.
//   m8           8 rings from -18.25 to 3.2 degrees (Quanergy M8), 50 us; 2000 groups.
//   os0-, os1-, os2-{32,64,128}
//                as many rings within 45, 22.5, 11.25 degrees of the horizon; 1024 groups; 50, 120,
//                240 m.
// And that do not:
//   solid        a raster of 240 by 100 directions, 120 by 90 degrees ahead; rows from top to
//                bottom, each from left to right; 75 m.
//   mid360       20000 directions all round, from -7 to 52 degrees, spread as evenly at any time of
//                the scan as in all of it; turned by the golden angle from scan to scan; 70 m.
//   mid70        10000 directions along a rosette, 70.4 degrees wide, that two prisms turning
//                against each other draw ahead; turned likewise about the line of sight; 90 m.
// InvalidArgument, listing the names, for any other.
absl::StatusOr<Lidar> MakeLidar(const std::string& name);

std::vector<std::string> LidarNames();

}  // namespace isthmus::simulation
