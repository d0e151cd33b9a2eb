// Options of an OctoMap: how fine, how far rays count, which part of the map.
#pragma once

#include <cstdint>

#include "core/ids.h"
#include "core/map/composed_map.h"
#include "server/composition/occupancy/sensor_evidence.h"

namespace isthmus::composition {

struct OccupancyOptions {
  double resolution_m = 0.2;  // Edge of the smallest voxels, 0.01 to 10.
  // Rays are cut here: the way there is free, what lies beyond is not inserted as occupied. At
  // least the resolution, at most 1000.
  double max_range_m = 30;
  SensorModel sensor = {};  // Must be the same for all maps of one KeptOccupancy.
  RobotId robot = {};       // Its rays alone; empty: all robots'.
  // Voxels whose middle is not in its box, sphere and shape are left out, and columns without any
  // are not cast.
  Region region = {};
  uint64_t max_bytes = uint64_t{1} << 30;  // Memory for building a file, about.
};

}  // namespace isthmus::composition
