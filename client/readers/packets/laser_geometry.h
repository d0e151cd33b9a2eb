// The geometry of a sensor that spins: from an azimuth and a range to a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers {

inline constexpr int kTurn = 36000;  // Math: hundredths of a degree.

// The same azimuth, in [0, kTurn).
inline int Turned(int azimuth) { return (azimuth % kTurn + kTurn) % kTurn; }

// A laser's place and corrections, metres and radians. The terms are those of the calibration of
// the HDL-64E S2 (User's Manual, appendix on two point calibration), which other sensors leave 0.
struct Laser {
  double elevation = 0;
  double rotation = 0;  // Points at azimuth minus this.
  double vertical_offset = 0, horizontal_offset = 0;
  // Added to z alone, after all else: the vertical correction of the VLP-16 User Manual, table 9-1.
  double height = 0;
  // Added to the range: far away, and in x and y (of the manual) near the sensor.
  double range_far = 0, range_near_x = 0, range_near_y = 0;
  bool two_point = false;
  double focal_distance = 0, focal_slope = 0;  // For the intensity; distance in centimetres.
  double min_intensity = 0, max_intensity = 255;
};

struct Calibration {
  std::vector<Laser> lasers;  // By number.
  double range_unit_m = 0.002;
  std::string source;  // "the tables of the VLP-16 User Manual"
};

// Angles, degrees; `azimuths_deg` are added to that of a block. Null: all 0.
Calibration MakeCalibration(std::string source, int lasers, const double* elevations_deg,
                            const double* azimuths_deg);

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
  // `azimuth` in hundredths of a degree, within a few turns; `range` as sent, not 0.
  Position Locate(size_t laser, double azimuth, uint16_t range, uint8_t reflectivity) const;

 private:
  struct Prepared {
    Laser laser;
    double sin_elevation, cos_elevation;
    double rotation;           // Hundredths of a degree.
    double xy_shift, z_shift;  // Offset of the laser.
    bool two_point, focus;     // True if the correction changes anything.
    double focal_offset;
    uint16_t ring;
  };
  struct Angle {
    double sin, cos;
  };
  Angle AngleOf(double azimuth) const;

  double range_unit_m_;
  std::vector<Prepared> lasers_;
  std::vector<Angle> angles_;  // For each hundredth of a degree.
};

}  // namespace isthmus::readers
