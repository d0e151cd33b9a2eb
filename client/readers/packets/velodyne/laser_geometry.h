// The geometry of a Velodyne sensor: from an azimuth and a range to a point.
#pragma once

#include <cstdint>
#include <vector>

#include "client/readers/packets/velodyne/velodyne_model.h"

namespace isthmus::readers::velodyne {

// HDL-64E S2 User's Manual, sample code for coordinates, of which that of the other manuals is a
// special case; the frame is that of ROS: x forward (the manual's +y, azimuth 0), y left, z up.
// Immutable.
class LaserGeometry {
 public:
  explicit LaserGeometry(const Calibration& calibration);

  struct Position {
    float x, y, z;
    float intensity;  // 0 to 255.
    uint16_t ring;    // 0: lowest.
  };
  // `azimuth` in hundredths of a degree, any number; `range` as sent, not 0.
  Position Locate(size_t laser, double azimuth, uint16_t range, uint8_t reflectivity) const;

 private:
  struct Prepared {
    Laser laser;
    double sin_elevation, cos_elevation;
    double rotation;           // Hundredths of a degree.
    double xy_shift, z_shift;  // Of the offset of the laser.
    bool two_point, focus;     // Whether that changes anything.
    double focal_offset;
    uint16_t ring;
  };
  struct Angle {
    double sin, cos;
  };
  Angle AngleOf(double azimuth) const;

  double range_unit_m_;
  std::vector<Prepared> lasers_;
  std::vector<Angle> angles_;  // Of each hundredth of a degree.
};

}  // namespace isthmus::readers::velodyne
