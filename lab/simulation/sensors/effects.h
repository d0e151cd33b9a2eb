// Effects of weather, surfaces and imperfect sensors on one turn's measurements.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/lidar.h"
#include "lab/simulation/sensors/ray_caster.h"

namespace isthmus::simulation {

// Something of the robot itself, or who carries it, in the sensor's view: in the sensor frame,
// azimuth counter-clockwise from ahead, radians.
struct Shade {
  float azimuth = 0, half_width = 0;
  float highest = 0;  // Elevation up to which it reaches.
  float range_m = 0;  // 0: nothing comes back from there.
};

// All zero and empty: none, and measurements are bit for bit those without. Value type.
struct Effects {
  double rain = 0;     // Share of rays that a drop sends back from within some metres.
  double dust = 0;     // The same of dust, where its clouds are densest; as many are lost in it.
  double foliage = 0;  // Share of hits on leaves that are hit in part only.
  double glass = 0;    // 0: glass is seen as all else. Else rays pass it, and this share of those
                       // that would is mirrored.
  double blooming_rad = 0;  // Retro-reflectors look this much larger to every side.
  double mixed = 0;         // Share of edges with a point between the near and the far side.
  double packet_loss = 0;   // Share of packets, of 12 groups each, that never arrive.
  std::vector<Shade> shades = {};

  // Calibration: one sigma, of every ring by itself.
  double ring_range_sigma_m = 0, ring_angle_sigma_rad = 0;
  // Errors of a scan's stamp: the greatest delay on top of the truth, and the rate by which the
  // clock is fast.
  double stamp_jitter_s = 0, clock_drift = 0;

  // True if any but of calibration and stamps is there.
  bool Disturb() const;
};

// The differences of a sensor's rings from their nominal values.
class Miscalibration {
 public:
  Miscalibration(const Effects& effects, const Lidar& lidar, uint64_t seed);

  // The true direction of a firing, sensor frame.
  Eigen::Vector3f Direction(const Firing& firing) const;
  // The offset added to its range.
  float RangeOffset(const Firing& firing) const { return rings_[firing.ring].range_m; }

 private:
  struct Ring {
    double up_rad = 0, left_rad = 0;
    float range_m = 0;
  };
  bool turned_;
  std::vector<Ring> rings_;
};

// The delay of the stamp of the index-th scan, seconds.
double StampError(const Effects& effects, double end_s, uint64_t seed, int index);

// Casts rays of a scan; `firings` says which they are.
using Trace = std::function<void(std::span<const Ray> rays, std::span<const size_t> firings,
                                 std::span<Hit> hits)>;

// A whole scan as it was cast: a ray and a hit for each firing.
struct CastScan {
  std::span<const Firing> firings;
  size_t lasers = 1;  // See Lidar.
  std::span<const Ray> rays;
  std::span<Hit> hits;
  double begin_s = 0;
};

// Changes the hits of the scan.
void Disturb(const Effects& effects, const CastScan& scan, const Trace& trace, Random& random);

}  // namespace isthmus::simulation
