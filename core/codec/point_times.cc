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

// Odd times are farther from the middle nine tenths than three halves of what these span, so that
// four times their span is left. Returns of a turn may crowd in a part of it: where the times make
// sense as they are, only so many are taken for odd.
constexpr double kAsideShare = 0.05;
constexpr double kFarSpans = 1.5;
constexpr double kOddShare = 0.01;
// A scan that lasts longer than this many turns is looked through for odd times.
constexpr double kLongerTurn = 1.25;
constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();

// Times since 1970, by their magnitude: that of their unit, and seconds per unit. What was counted
// since a sensor was switched on may be as large, but for the first.
constexpr double kNsSince1970 = 1e18;
struct Since1970 {
  double least, most, unit_s;
};
constexpr std::array<Since1970, 4> kSince1970 = {
    {{kNsSince1970, 1e300, 1e-9}, {1e15, kNsSince1970, 1e-6}, {1e12, 1e15, 1e-3}, {1e9, 1e12, 1}}};

// False for the largest uint32.
bool IsTime(ScalarType type, double value) {
  return type != ScalarType::kUint32 || value != std::numeric_limits<uint32_t>::max();
}

// Makes what is not finite NaN, and replaces the largest uint32. False where there is no time.
bool FillTimes(ScalarType type, std::vector<double>& times) {
  const auto is_time = [&](double t) { return std::isfinite(t) && IsTime(type, t); };
  const auto first = std::find_if(times.begin(), times.end(), is_time);
  if (first == times.end()) return false;
  double last = *first;
  for (double& t : times) {
    if (is_time(t)) {
      last = t;
    } else {
      t = IsTime(type, t) ? kNoTime : last;
    }
  }
  return true;
}

// Adds a turn of the counter to the values after it started again within the scan, if that alone
// makes the times those of one turn.
void UnwrapCounter(double first, double last, std::vector<double>& times) {
  const double span = last - first;
  for (const double modulus : kModuli) {
    if (span < 0.5 * modulus || span > modulus) continue;
    double low = last, high = first;
    for (const double t : times) {
      if (t - first < 0.5 * modulus) {
        high = std::max(high, t + modulus);
      } else if (!std::isnan(t)) {
        low = std::min(low, t);
      }
    }
    if (std::none_of(kUnits_s.begin(), kUnits_s.end(),
                     [&](double unit) { return IsTurn((high - low) * unit); })) {
      continue;
    }
    const double middle = first + 0.5 * modulus;
    for (double& t : times) {
      if (t < middle) t += modulus;
    }
    return;
  }
}

bool IsScan(double seconds) { return seconds >= kShortestPart_s && seconds <= kLongestTurn_s; }

// Seconds per unit where `span` units are one scan that ends at `last`; 0 where none makes sense.
double GuessUnit(ScalarType type, double span, double last) {
  for (const auto& [least, most, unit] : kSince1970) {
    if (last >= least && last < most && IsScan(span * unit)) return unit;
  }
  if (last >= kNsSince1970) return 0;
  for (const double unit : kUnits_s) {
    if (IsTurn(span * unit)) return unit;
  }
  const bool floating = type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  const double unit = floating ? 1.0 : 1e-9;
  return IsScan(span * unit) ? unit : 0;
}

}  // namespace

bool IsTurn(double seconds) { return seconds >= kShortestTurn_s && seconds <= kLongestTurn_s; }

TimeReader::Range TimeReader::RangeOf(const std::vector<double>& times) {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double t : times) {
    if (t < range.first) range.first = t;  // False for NaN.
    if (t > range.last) range.last = t;
  }
  return range;
}

// That of the times which are not far from the middle nine tenths; how many are.
TimeReader::Range TimeReader::RangeOfMost(const std::vector<double>& times, size_t* odd) {
  scratch_.clear();
  for (const double t : times) {
    if (!std::isnan(t)) scratch_.push_back(t);
  }
  const auto aside =
      static_cast<std::ptrdiff_t>(kAsideShare * static_cast<double>(scratch_.size()));
  const auto low = scratch_.begin() + aside, high = scratch_.end() - 1 - aside;
  std::nth_element(scratch_.begin(), low, scratch_.end());
  if (low < high) std::nth_element(low + 1, high, scratch_.end());
  const double far = kFarSpans * (*high - *low), first = *low - far, last = *high + far;
  *odd = std::erase_if(scratch_, [&](double t) { return t < first || t > last; });
  return RangeOf(scratch_);
}

// As of the turns before; of a first scan, or where they cannot be meant, a guess.
double TimeReader::UnitFor(ScalarType type, const Range& range, double given_s) const {
  if (given_s > 0) return IsScan(range.span() * given_s) ? given_s : 0;
  if (unit_s_ > 0) return range.span() * unit_s_ <= kLongestTurn_s ? unit_s_ : 0;
  return GuessUnit(type, range.span(), range.last);
}

// The times that are no odd ones, and seconds per unit; 0 where these make no sense.
TimeReader::Range TimeReader::Understand(ScalarType type, double given_s,
                                         std::vector<double>& times, double* unit) {
  Range range = RangeOf(times);
  *unit = UnitFor(type, range, given_s);
  if (*unit == 0) {
    UnwrapCounter(range.first, range.last, times);
    range = RangeOf(times);
    *unit = UnitFor(type, range, given_s);
  }
  // A first scan may be wrong in what it seems to be.
  if (*unit > 0 && turn_s_ > 0 && range.span() * *unit <= kLongerTurn * turn_s_) return range;
  size_t odd = 0;
  const Range most = RangeOfMost(times, &odd);
  const bool few = static_cast<double>(odd) <= kOddShare * static_cast<double>(times.size());
  if (*unit == 0 || few) {
    const bool stands = turn_s_ == 0 && most.first == 0 && most.last == 0;
    const double of_most = UnitFor(type, most, given_s);
    if (of_most > 0 || stands) {
      *unit = of_most;
      return most;
    }
  }
  if (*unit == 0 && unit_s_ > 0) *unit = GuessUnit(type, range.span(), range.last);
  return range;
}

bool TimeReader::Read(ScalarType type, int64_t end_stamp_ns, std::vector<double>& times,
                      double unit_s) {
  if (!FillTimes(type, times)) return false;
  double unit = 0;
  const Range range = Understand(type, unit_s, times, &unit);
  if (unit == 0) {
    if (turn_s_ > 0 || range.first != 0 || range.last != 0) return false;
    zero_ = Zero::kInstant;
  }
  last_ = {.unit_s = unit, .first_s = range.first * unit, .end_s = 0, .odd = 0};
  if (unit > 0) {
    last_.end_s = EndOf(last_.first_s, range.last * unit, 1e-9 * static_cast<double>(end_stamp_ns));
    if (IsTurn(range.span() * unit)) unit_s_ = unit;
  }
  for (double& t : times) {
    const bool odd = !(t >= range.first && t <= range.last);  // True for NaN.
    last_.odd += odd ? 1 : 0;
    t = odd ? kNoTime : std::min(0.0, t * unit - last_.end_s);
  }
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
    case Zero::kInstant:
      return "all 0: motion-compensated already";
    case Zero::kClock:
      break;
  }
  return absl::StrCat(name, ", of a clock");
}

}  // namespace isthmus::codec
