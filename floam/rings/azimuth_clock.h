// Times of points that have none, from where the sensor looked.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

// Duration of a turn from the stamps of scans that follow each other.
class TurnPeriod {
 public:
  // `assumed_s` unless the last scans say otherwise; scans that were dropped do not disturb it.
  double Update(int64_t end_stamp_ns, double assumed_s);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.last_ns_, self.intervals_s_);
  }

 private:
  int64_t last_ns_ = 0;
  std::vector<double> intervals_s_;  // The last few.
};

// Tells time from azimuth for the scans of one sensor, one after the other. Not thread safe.
//
// Points of one ring that follow each other in azimuth tell in which sense the sensor turns and
// where the scan begins. The result of whole scans is remembered for scans that miss a part. If
// points are in no such order, or not in that of time (SensorModel::sorted_files), start and sense
// are the model's.
class AzimuthClock {
 public:
  // Azimuth (radians) and ring (below `ring_count`) of every point, in the order of points; fills
  // `*times` with seconds relative to the END of a scan that takes `period_s`.
  void Assign(const std::vector<float>& azimuths, const std::vector<uint16_t>& rings,
              int ring_count, const SensorModel& model, double period_s, std::vector<float>* times);

  // Findings from the last scan.
  bool from_order() const { return from_order_; }
  bool clockwise() const { return sense_ < 0; }
  double start_azimuth() const { return start_; }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.from_order_, self.ring_by_ring_, self.sense_, self.start_, self.start_known_,
       self.whole_turns_);
    if constexpr (Io::kIsReading) {
      io.Expect(std::abs(self.sense_) == 1 && std::abs(self.start_) < 10 && self.whole_turns_ > 0);
    }
  }

 private:
  struct Ring {
    float first = 0, last = 0;    // Azimuths.
    float forward = 0, path = 0;  // Sum of steps, signed and not; of those that are steps.
    float turns = 0;              // Since the start of the scan.
    uint32_t count = 0;
  };

  // True if the order of points is that of time.
  bool Follow(const std::vector<float>& azimuths, const std::vector<uint16_t>& rings,
              int ring_count, const SensorModel& model);
  float TurnsSince(float azimuth, float start) const;
  float MedianStart() const;
  float MedianExtent() const;
  void CountTurns(const std::vector<float>& azimuths, const std::vector<uint16_t>& rings,
                  float start, std::vector<float>* turns);

  std::vector<Ring> rings_;
  std::vector<uint32_t> full_rings_;  // Rings that see something all around.
  mutable std::vector<float> scratch_;
  bool from_order_ = false;
  bool ring_by_ring_ = false;  // The points come, rather than firing by firing.
  float sense_ = -1;           // Counter-clockwise is positive.
  float start_ = 0;            // Start of the last whole scan, or the model's.
  bool start_known_ = false;
  float whole_turns_ = 1;  // Turns of a whole scan.
};

}  // namespace isthmus::floam
