#include "client/readers/packets/sensor_clock.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cstdlib>

#include "client/readers/packets/limits.h"

namespace isthmus::readers {
namespace {

// Differences of times within this do not overflow. Layout: 32 bits of seconds.
constexpr int64_t kLatestTimeNs = 4'294'967'296'000'000'000;  // Layout

// The same, in [-period / 2, period / 2).
int64_t WrappedTo(int64_t value, int64_t period) {
  const int64_t rest = ((value % period) + period) % period;
  return rest >= period / 2 ? rest - period : rest;
}

}  // namespace

int64_t SensorClock::Read(int64_t sensor_ns, int64_t arrival_ns) {
  sensor_ns = std::clamp<int64_t>(sensor_ns, 0, kLatestTimeNs);
  arrival_ns = std::clamp<int64_t>(arrival_ns, 0, kLatestTimeNs);
  const int64_t utc_delay = std::clamp(-utc_offset_ns_.value_or(0), -kLatestTimeNs, kLatestTimeNs);
  int64_t delay = arrival_ns - sensor_ns;
  if (period_ns_ > 0) {
    // Near the one before: an hour begins for the sensor and for the host at different instants.
    const int64_t expected = started_ ? last_delay_ : utc_delay;
    delay = expected + WrappedTo(delay % period_ns_ - expected % period_ns_, period_ns_);
  }
  if (!started_) first_delay_ = delay;
  const bool agrees =
      utc_offset_ns_.has_value() || std::abs(delay - utc_delay) <= kClockAgreementNs;
  if (!started_ || (synchronised_ && !agrees)) {
    was_synchronised_ = started_;
    synchronised_ = agrees;
    least_delay_ = window_delay_ = delay;
    window_start_ = arrival_ns;
  }
  started_ = true;
  last_delay_ = delay;
  if (!synchronised_) Follow(delay, arrival_ns);
  return arrival_ns - delay;
}

void SensorClock::Follow(int64_t delay, int64_t arrival_ns) {
  const bool jumped = std::abs(delay - window_delay_) > kClockJumpNs;
  const bool backwards = arrival_ns < window_start_;
  if (jumped || backwards) {
    least_delay_ = window_delay_ = delay;
    window_start_ = arrival_ns;
    return;
  }
  if (arrival_ns - window_start_ > kDelayWindowNs) {
    least_delay_ = std::min(window_delay_, delay);
    window_delay_ = delay;
    window_start_ = arrival_ns;
  }
  window_delay_ = std::min(window_delay_, delay);
  least_delay_ = std::min(least_delay_, delay);
}

std::string SensorClock::Description() const {
  if (!started_) return {};
  if (synchronised_ && utc_offset_ns_) {
    return "stamps are of the sensor's clock, which its GNSS receiver sets to UTC";
  }
  if (synchronised_) {
    return "stamps are of the sensor's clock, which agrees with that of arrival";
  }
  if (was_synchronised_) {
    return "the sensor's clock went away from that of arrival: stamps since then are of arrival, "
           "by the least delay of the last 10 to 20 s";
  }
  return absl::StrFormat(
      "the sensor's clock is not synchronised (%.3f s before that of arrival): stamps are of "
      "arrival, by the least delay of the last 10 to 20 s",
      static_cast<double>(first_delay_) * 1e-9);
}

}  // namespace isthmus::readers
