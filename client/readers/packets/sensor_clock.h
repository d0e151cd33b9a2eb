// The clock of a sensor, put on Unix time by when its packets arrived.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace isthmus::readers {

// A clock that agrees with that of arrival is believed. Any other is put on the clock of arrival by
// the least delay of the last 10 to 20 s (limits.h), so that its exact steps are kept and the
// jitter of the network is not. Not thread safe.
class SensorClock {
 public:
  // `period_ns`: when the clock starts again, 3600 s for one of the hour; 0 for never.
  // `utc_offset_ns`: the clock is known to be UTC, and arrival plus this is UTC, too, to within a
  // quarter of the period.
  explicit SensorClock(int64_t period_ns, std::optional<int64_t> utc_offset_ns = std::nullopt)
      : period_ns_(period_ns), utc_offset_ns_(utc_offset_ns) {}

  // The time of a packet, without the jumps where the clock starts again. Counts from anywhere;
  // Unix time is offset_ns() more. Times before 1970 and after 2106 are taken for these.
  int64_t Read(int64_t sensor_ns, int64_t arrival_ns);
  // As of the last packet.
  int64_t offset_ns() const { return synchronised_ ? 0 : least_delay_; }

  // "stamps are of the sensor's clock, which agrees with that of arrival". Empty before the first
  // packet.
  std::string Description() const;

 private:
  void Follow(int64_t delay, int64_t arrival_ns);

  int64_t period_ns_;
  std::optional<int64_t> utc_offset_ns_;
  bool started_ = false;
  bool synchronised_ = false;
  bool was_synchronised_ = false;
  int64_t first_delay_ = 0;  // Arrival minus sensor time, of the first packet.
  int64_t last_delay_ = 0;
  // The least delay of this window and the one before it.
  int64_t least_delay_ = 0, window_delay_ = 0, window_start_ = 0;
};

}  // namespace isthmus::readers
