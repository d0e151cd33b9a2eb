#include "core/codec/point_times.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isthmus::codec {
namespace {

// A spinning LiDAR turns 2 to 50 times a second. The longest turn is less than a thousand times
// the shortest, so at most one of the units below fits.
constexpr double kShortestTurn_s = 0.02;
constexpr double kLongestTurn_s = 0.5;
// A part of a turn may be shorter; below this the field carries no time at all.
constexpr double kShortestPart_s = 1e-3;
constexpr std::array<double, 4> kUnits_s = {1, 1e-3, 1e-6, 1e-9};
constexpr std::array<const char*, 4> kUnitNames = {"s", "ms", "us", "ns"};
// The values at which counters wrap around, in their own units: 32 bits; the hour of Velodyne's
// packets, in us and s; the second, in ns and us.
constexpr std::array<double, 5> kModuli = {4294967296.0, 3.6e9, 3600, 1e9, 1e6};

// Times farther from zero than this are those of a clock: times from the start of a turn end with
// it.
constexpr double kMaxRelative_s = kLongestTurn_s;
constexpr double kClockSlack_s = 1e-3;
// Turns in a row that must begin at zero before what was a clock is none any more: a counter that
// starts again gives one such turn by chance.
constexpr int kTurnsFromZero = 2;
// A scan that lasts less than this share of a turn misses a part of it.
constexpr double kWholeShare = 0.9;
// A turn is forgotten at this rate per scan, so that a sensor that was set to turn faster is not
// taken to miss parts for ever.
constexpr double kForget = 0.99;

// Replaces what is no time.
void FillTimes(ScalarType type, std::vector<double>& times) {
  const auto is_time = [&](double t) { return IsTime(type, t); };
  const auto first = std::find_if(times.begin(), times.end(), is_time);
  if (first == times.end()) return;
  double last = *first;
  for (double& t : times) last = t = is_time(t) ? t : last;
}

bool IsTurn(double seconds) { return seconds >= kShortestTurn_s && seconds <= kLongestTurn_s; }

// Adds a turn of the counter to the values after it started again within the scan, if that alone
// makes the times those of one turn.
void UnwrapCounter(std::vector<double>& times) {
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  const double span = *last - *first;
  for (const double modulus : kModuli) {
    if (span < 0.5 * modulus || span > modulus) continue;
    double low = *last, high = *first;
    for (const double t : times) {
      if (t - *first < 0.5 * modulus) {
        high = std::max(high, t + modulus);
      } else {
        low = std::min(low, t);
      }
    }
    if (std::none_of(kUnits_s.begin(), kUnits_s.end(),
                     [&](double unit) { return IsTurn((high - low) * unit); })) {
      continue;
    }
    const double middle = *first + 0.5 * modulus;
    for (double& t : times) {
      if (t < middle) t += modulus;
    }
    return;
  }
}

}  // namespace

bool IsTime(ScalarType type, double value) {
  return type != ScalarType::kUint32 || value != std::numeric_limits<uint32_t>::max();
}

double SecondsPerUnit(ScalarType type, double span) {
  for (const double unit : kUnits_s) {
    if (IsTurn(span * unit)) return unit;
  }
  const bool floating = type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  const double unit = floating ? 1.0 : 1e-9;
  return span * unit >= kShortestPart_s && span * unit <= kLongestTurn_s ? unit : 0;
}

bool TimeReader::Read(ScalarType type, int64_t end_stamp_ns, std::vector<double>& times) {
  if (times.empty()) return false;
  if (!std::all_of(times.begin(), times.end(), [](double t) { return std::isfinite(t); })) {
    return false;
  }
  FillTimes(type, times);
  auto range = std::minmax_element(times.begin(), times.end());
  double unit = SecondsPerUnit(type, *range.second - *range.first);
  if (unit == 0) {
    UnwrapCounter(times);
    range = std::minmax_element(times.begin(), times.end());
    unit = SecondsPerUnit(type, *range.second - *range.first);
  }
  const double span = *range.second - *range.first;
  if (unit_s_ > 0 && span * unit_s_ <= kLongestTurn_s) unit = unit_s_;
  if (unit == 0) return false;
  const double end_s =
      EndOf(*range.first * unit, *range.second * unit, 1e-9 * static_cast<double>(end_stamp_ns));
  if (IsTurn(span * unit)) unit_s_ = unit;
  for (double& t : times) t = std::min(0.0, t * unit - end_s);
  return true;
}

TimeReader::Zero TimeReader::ZeroOfTurn(double first_s, double last_s) {
  from_zero_ = std::abs(first_s) <= kClockSlack_s ? from_zero_ + 1 : 0;
  if (zero_ == Zero::kClock && from_zero_ < kTurnsFromZero && last_s > kClockSlack_s) return zero_;
  return first_s < -kClockSlack_s && last_s <= kClockSlack_s ? Zero::kEnd : Zero::kStart;
}

double TimeReader::EndOf(double first_s, double last_s, double stamp_s) {
  const double span_s = last_s - first_s;
  const bool whole = span_s >= kWholeShare * turn_s_;
  if (std::abs(last_s) > kMaxRelative_s) {
    zero_ = Zero::kClock;
    from_zero_ = 0;
  } else if (whole) {
    zero_ = ZeroOfTurn(first_s, last_s);
  }
  const double shift_s = zero_ == Zero::kClock ? stamp_s : 0;
  const double turn_s = turn_s_;
  turn_s_ = std::max(span_s, kForget * turn_s_);
  if (whole) {
    end_s_ = last_s - shift_s;
    return last_s;
  }
  const double expected_s = end_s_ + shift_s;
  const bool plausible = expected_s >= last_s && expected_s - first_s <= turn_s / kWholeShare;
  return plausible ? expected_s : last_s;
}

void TimeReader::Restore(const Memory& memory) {
  unit_s_ = memory.unit_s;
  turn_s_ = memory.turn_s;
  end_s_ = memory.end_s;
  zero_ = memory.zero;
}

std::string TimeReader::Description() const {
  const auto unit = std::find(kUnits_s.begin(), kUnits_s.end(), unit_s_);
  const char* name = unit == kUnits_s.end() ? "unit unclear" : kUnitNames[unit - kUnits_s.begin()];
  switch (zero_) {
    case Zero::kStart:
      return absl::StrCat(name, ", from the start of the scan");
    case Zero::kEnd:
      return absl::StrCat(name, ", up to the end of the scan");
    case Zero::kClock:
      break;
  }
  return absl::StrCat(name, ", of a clock");
}

}  // namespace isthmus::codec
