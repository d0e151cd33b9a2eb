// The patterns that simulated LiDARs look in; see MakeLidar.
#pragma once

#include <cstdint>
#include <vector>

#include "client/simulation/sensors/lidar.h"

namespace isthmus::simulation {

// A laser of a spinning sensor.
struct Laser {
  uint16_t ring = 0;
  double elevation_deg = 0;
  double offset_s = 0;  // Since its group began.
};

// In the order of firing. Rings 0, n/2, 1, n/2 + 1, ...: neighbours in time are far apart in
// elevation.
std::vector<Laser> Interleaved(int rings, double lowest_deg, double step_deg, double slot_s);
std::vector<Laser> Vlp32();
std::vector<Laser> Hdl64(double group_s);
std::vector<Laser> M8(double slot_s);

// Each of these fills `firings`, `lasers`, `has_rings` and `turn_per_scan`.
void Spin(const std::vector<Laser>& lasers, double group_s, Lidar* lidar);
void ScanRaster(int columns, int rows, double width_deg, double height_deg, Lidar* lidar);
void Scatter(int count, double lowest_deg, double highest_deg, Lidar* lidar);
void DrawRosette(int count, double width_deg, Lidar* lidar);

}  // namespace isthmus::simulation
