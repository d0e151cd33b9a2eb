// A scan sorted into rings, or bands of elevation where there are none, every point with its time:
// what feature extraction works on.
#pragma once

#include <absl/status/status.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/scan.h"
#include "floam/rings/azimuth_clock.h"
#include "floam/rings/limits.h"
#include "floam/rings/ring_inference.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

struct RingPoint {
  float x = 0, y = 0, z = 0;  // Metres, sensor frame at the instant of the measurement.
  float intensity = 0;
  float time = 0;   // Seconds relative to the END of the scan, in [-period_s, 0].
  float range = 0;  // Metres.

  Eigen::Vector3f Position() const { return {x, y, z}; }
};

// The origin of a point's ring or time.
enum class Inference {
  kSensor,       // Fields of the scan.
  kPointOrder,   // Order of the points: ring after ring, or firing after firing.
  kSensorModel,  // Elevations, or start azimuth and sense of rotation, of the sensor model.
  kHistogram,    // Elevations that the scan itself shows.
  kNone,         // There are no rings; times are not known.
};

// A description of a session's scans.
struct InputText {
  std::string rings;    // "16, given", "64, by the order of points", ...
  std::string times;    // "given", "from azimuth, clockwise from 180 deg", ...
  std::string warning;  // Misfits to the sensor that was named; else empty.
};

struct RingScan {
  // Ring k is points [ring_begin[k], ring_begin[k + 1]), in order of azimuth. Rings are in order of
  // elevation, one way or the other; some may be empty. Without rings (`rings_from` is kNone) bands
  // of elevation take their place, kBandRad high, from straight down to straight up, their points
  // in the order they came in.
  std::vector<RingPoint> points;
  std::vector<uint32_t> ring_begin;
  double period_s = 0.1;  // Duration of the turn, or of the scan.
  // Positions are those of the END already; times tell the order of points in their rings only.
  bool is_compensated = false;
  Inference rings_from = Inference::kSensor;
  Inference times_from = Inference::kSensor;
  InputText text;

  bool in_rings() const { return rings_from != Inference::kNone; }
};

// Sorts the scans of one sensor into rings, one after the other, and remembers what they showed:
// which elevations the rings have, in which sense the sensor turns and where scans begin. Not
// thread safe.
class RingSorter {
 public:
  // Sorts `scan` into `*out` (whose memory is reused), dropping points outside the model's range
  // and all but the farthest of several returns along one ray. A turn is taken to last `period_s`
  // where the scan has no times and the stamps do not say otherwise. InvalidArgument, `*out`
  // unspecified, for scans that cannot be used: too few points in range, all in one place,
  // coordinates or times that are not finite, times after the END or more than two seconds before
  // it; and of a model with so many rings, scans with more, and points that do not lie in rings as
  // those of a spinning LiDAR do. If the number of rings is not known, the first scan that is
  // sorted tells if there are any. Without rings, points without times are taken to have been
  // measured at the END. If all times are 0 the scan is motion-compensated already, and times are
  // told by azimuth, or are 0 without rings.
  absl::Status Sort(const Scan& scan, const SensorModel& model, double period_s, RingScan* out);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.scans_, self.rings_unordered_, self.seam_, self.seam_known_, self.origin_,
       self.histogram_, self.rings_at_, self.rings_at_from_, self.histogram_scans_, self.clock_,
       self.turn_period_, self.rings_seen_, self.mismatch_);
    if constexpr (Io::kIsReading) io.Expect(self.rings_at_.size() <= kMaxRings);
  }

 private:
  absl::Status Validate(const Scan& scan, const SensorModel& model);
  absl::Status SortIntoRings(const Scan& scan, const SensorModel& model, double period_s,
                             RingScan* out);
  void SortIntoBands(const Scan& scan, const SensorModel& model, double period_s, RingScan* out);
  absl::Status AssignRings(const Scan& scan, const SensorModel& model, RingScan* out);
  absl::Status TakeGivenRings(const Scan& scan, const SensorModel& model);
  absl::Status InferRings(const Scan& scan, const SensorModel& model, RingScan* out);
  absl::Status FindElevations(const Scan& scan, const SensorModel& model);
  void AssignTimes(const Scan& scan, const SensorModel& model, double period_s, RingScan* out);
  void Scatter(const Scan& scan, RingScan* out);
  absl::Status CheckFirst(const Scan& scan, const SensorModel& model, const RingScan& sorted);
  void Describe(const SensorModel& model, RingScan* out);

  // Scratch memory, one entry per point of the scan.
  std::vector<float> ranges_;  // Negative for points that are not used.
  std::vector<float> azimuths_, elevations_;
  std::vector<float> times_;
  std::vector<uint16_t> rings_;
  std::vector<uint32_t> next_;
  int ring_count_ = 0;
  int lowest_ring_ = 0, highest_ring_ = 0;  // Given by the points of the scan.
  bool has_times_ = false;                  // Times that are not all 0.
  bool is_shuffled_ = false;                // Not ring after ring, for all that it turns.

  // Knowledge from earlier scans.
  uint64_t scans_ = 0;  // Scans that were sorted.
  bool rings_unordered_ = false;
  float seam_ = 0;
  bool seam_known_ = false;
  BeamOrigin origin_;
  ElevationHistogram histogram_;
  std::vector<double> rings_at_;  // Elevations of the rings; empty before they are known.
  Inference rings_at_from_ = Inference::kSensorModel;  // kNone once known that there are none.
  uint64_t histogram_scans_ = 0;
  AzimuthClock clock_;
  TurnPeriod turn_period_;
  int rings_seen_ = 0;  // At most, in one scan.
  std::string mismatch_;
};

}  // namespace isthmus::floam
