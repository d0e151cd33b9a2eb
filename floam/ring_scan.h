// A scan sorted into rings, every point with its time: what feature extraction works on.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <vector>

#include "core/scan.h"
#include "floam/sensor_model.h"

namespace isthmus::floam {

struct RingPoint {
  float x = 0, y = 0, z = 0;  // Metres, sensor frame at the instant of the measurement.
  float intensity = 0;
  float time = 0;   // Seconds relative to the END of the scan, in [-period_s, 0].
  float range = 0;  // Metres.
};

// Where ring or time of a point came from.
enum class Inference {
  kSensor,       // Fields of the scan.
  kPointOrder,   // Order of the points: ring after ring, or firing after firing.
  kSensorModel,  // Elevations, or start azimuth and sense of rotation, of the sensor model.
  kHistogram,    // Elevations that the scan itself shows.
};

struct RingScan {
  // Ring k is points [ring_begin[k], ring_begin[k + 1]), in order of azimuth. Rings are in order of
  // elevation, one way or the other; some may be empty.
  std::vector<RingPoint> points;
  std::vector<uint32_t> ring_begin;
  double period_s = 0.1;  // Duration of the turn.
  Inference rings_from = Inference::kSensor;
  Inference times_from = Inference::kSensor;
};

// Sorts `scan` into `*out` (whose memory is reused), dropping points outside the model's range.
// A turn is taken to last `period_s` where the scan has no times. InvalidArgument, `*out`
// unspecified, for scans that cannot be used: too few points in range, all in one place,
// coordinates or times that are not finite, times after the END or more than two seconds before it.
class RingSorter {
 public:
  absl::Status Sort(const Scan& scan, const SensorModel& model, double period_s, RingScan* out);

 private:
  absl::Status Validate(const Scan& scan, const SensorModel& model);
  void ComputeAngles(const Scan& scan);
  void AssignRings(const Scan& scan, const SensorModel& model, RingScan* out);
  void AssignTimes(const Scan& scan, const SensorModel& model, RingScan* out);
  void Scatter(const Scan& scan, const SensorModel& model, RingScan* out);

  // Scratch memory, one entry per point of the scan.
  std::vector<float> azimuths_;
  std::vector<float> times_;
  std::vector<uint16_t> rings_;
  std::vector<uint32_t> next_;
  int ring_count_ = 0;
  double turns_ = 0;  // Turns, counter-clockwise, that the azimuth makes in the order of points.
};

}  // namespace isthmus::floam
