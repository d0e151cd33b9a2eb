// A small world with exact answers: a room with boxes in it, and a LiDAR that moves while it turns.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::floam::testing {

struct Cuboid {
  Eigen::Vector3d min, max;
};

struct Room {
  Cuboid walls{{-10, -7, -1.2}, {10, 7, 3.8}};  // Seen from inside.
  std::vector<Cuboid> boxes;                    // Seen from outside.

  // Distance to the nearest surface along a unit vector; the origin must be inside the walls.
  double Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
};

// The room above with pillars, cupboards and a step on the floor.
Room FurnishedRoom();

// T_world_sensor at a time in seconds.
using Motion = std::function<Pose(double)>;

struct Sensor {
  int rings = 16;
  double lowest_rad = -0.2618, highest_rad = 0.2618;
  int columns = 1200;
  double period_s = 0.1;
  double noise_m = 0.01;
};

// The index-th turn of a sensor that begins at the rear and turns clockwise, every column cast from
// where the sensor is at that instant. Points in order of firing, with ring and time. The END of
// scan k is at (k + 1) periods; noise depends on `index` only.
Scan MakeScan(const Room& room, const Motion& motion, const Sensor& sensor, int index);

// The direction in which a sensor without rings takes the k-th of `points` measurements of a scan,
// a unit vector.
using Pattern = std::function<Eigen::Vector3d(int k, int points, int index)>;
// 120 by 90 degrees ahead, row by row from the top.
Eigen::Vector3d Raster(int k, int points, int index);
// All round, 7 degrees down to 52 up, scattered evenly; another way in every scan.
Eigen::Vector3d Scattered(int k, int points, int index);

// The index-th scan of a sensor that looks at `points` directions one after the other, each from
// where it is at that instant; else as above, without rings.
Scan MakeScanWithoutRings(const Room& room, const Motion& motion, const Pattern& pattern,
                          int points, int index, double noise_m = 0.01);

// T_world_sensor at the END of scan `index`.
Pose EndPose(const Motion& motion, const Sensor& sensor, int index);

// At rest.
inline Pose Still(double) { return Pose(); }
// Once around an ellipse, `speed` m/s, looking ahead; at rest for the first half second and then
// speeding up over one second.
Motion Loop(double speed);

}  // namespace isthmus::floam::testing
