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
// Counters that wrap around, at a value in their own units: 32 bits; the hour of Velodyne's
// packets; the second.
struct Counter {
  double unit_s, modulus;
};
constexpr std::array<Counter, 6> kCounters = {{{1e-9, 4294967296.0},
                                               {1e-6, 4294967296.0},
                                               {1e-6, 3.6e9},
                                               {1, 3600},
                                               {1e-9, 1e9},
                                               {1e-6, 1e6}}};

constexpr double kClockSlack_s = 1e-3;
// Turns in a row that must begin at zero before what was a clock is none any more: a counter that
// starts again gives one such turn by chance.
constexpr int kTurnsFromZero = 2;
// A scan that lasts less than this share of a turn misses a part of it.
constexpr double kWholeShare = 0.9;
// A turn is forgotten at this rate per scan, so that a sensor that was set to turn faster is not
// taken to miss parts for ever.
constexpr double kForget = 0.99;

// Share of the times that must lie in one turn for the others to be odd. Times of two sensors whose
// clocks differ are half and half: nothing tells which of the two sent the scan.
constexpr double kMostShare = 2.0 / 3;
// Times in the longest turn may still hold odd times of a shorter one: the ones farther from the
// middle nine tenths than three halves of the span of these, so that four times that span is left.
// Returns of a turn may crowd in a part of it: only so many are taken for odd.
constexpr double kAsideShare = 0.05;
constexpr double kFarSpans = 1.5;
constexpr double kOddShare = 0.01;
// A scan that lasts longer than this many turns is looked through for odd times.
constexpr double kLongerTurn = 1.25;
constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();

// Times since 1970, by their magnitude: that of their unit, and seconds per unit. Times counted
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

// Times of a scan that lie within some span of each other, and how many they are. If a counter
// started again, times below `seam` are read with its `modulus` added.
struct Bulk {
  double first = 0, last = 0;
  size_t count = 0;
  double modulus = 0, seam = 0;

  double span() const { return last - first; }
};

// The most of the sorted times that lie within `span`.
Bulk LargestWithin(const std::vector<double>& sorted, double span) {
  Bulk best;
  for (size_t begin = 0, end = 0; end < sorted.size(); ++end) {
    while (sorted[end] - sorted[begin] > span) ++begin;
    if (end - begin + 1 > best.count) best = {sorted[begin], sorted[end], end - begin + 1};
  }
  return best;
}

// The same across the value at which a counter starts again; none where nearly all are on one side.
Bulk LargestAcross(const std::vector<double>& sorted, double modulus, double span) {
  Bulk best;
  const auto zero = std::lower_bound(sorted.begin(), sorted.end(), 0.0);
  const auto end = std::upper_bound(zero, sorted.end(), modulus);
  const auto least =
      static_cast<std::ptrdiff_t>(kOddShare * static_cast<double>(sorted.size())) + 1;
  for (auto t = std::lower_bound(zero, end, modulus - span); end - t >= least; ++t) {
    const auto after = std::upper_bound(zero, t, *t + span - modulus);
    const auto count = static_cast<size_t>((end - t) + (after - zero));
    if (after - zero < least || count <= best.count) continue;
    best = {*t, *(after - 1) + modulus, count, modulus, 0.5 * modulus};
  }
  return best;
}

Bulk LargestTurn(const std::vector<double>& sorted, double unit_s) {
  const double span = kLongestTurn_s / unit_s;
  Bulk best = LargestWithin(sorted, span);
  for (const auto& [counted_s, modulus] : kCounters) {
    if (best.count == sorted.size()) break;
    if (counted_s != unit_s) continue;
    const Bulk across = LargestAcross(sorted, modulus, span);
    if (across.count > best.count) best = across;
  }
  return best;
}

double Median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

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

// The bulk of the sorted times where it is a scan in this unit.
std::optional<TimeReader::Range> TimeReader::TakeBulk(double unit_s, double least_s,
                                                      std::vector<double>& times) {
  Bulk bulk = LargestTurn(sorted_, unit_s);
  const bool is_most =
      static_cast<double>(bulk.count) >= kMostShare * static_cast<double>(sorted_.size());
  if (!is_most || bulk.span() * unit_s < least_s) return std::nullopt;
  for (double& t : times) {
    if (t < bulk.seam && t >= 0) t += bulk.modulus;
  }
  if (bulk.modulus > 0) return Range{bulk.first, bulk.last};
  const auto begin = std::lower_bound(sorted_.begin(), sorted_.end(), bulk.first);
  const auto end = begin + static_cast<std::ptrdiff_t>(bulk.count);
  const auto aside = static_cast<std::ptrdiff_t>(kAsideShare * static_cast<double>(bulk.count));
  const double low = *(begin + aside), high = *(end - 1 - aside), far = kFarSpans * (high - low);
  const auto first = std::lower_bound(begin, end, low - far);
  const auto last = std::upper_bound(first, end, high + far);
  const auto odd = static_cast<double>((first - begin) + (end - last));
  if (odd > kOddShare * static_cast<double>(bulk.count)) return Range{bulk.first, bulk.last};
  return Range{*first, *(last - 1)};
}

// As of the turns before; of a first scan, or where that cannot be meant, a guess.
std::optional<TimeReader::Range> TimeReader::TakeMost(ScalarType type, double given_s,
                                                      std::vector<double>& times, double* unit) {
  const auto take = [&](double unit_s, double least_s) {
    *unit = unit_s;
    return TakeBulk(unit_s, least_s, times);
  };
  if (given_s > 0) return take(given_s, kShortestPart_s);
  if (unit_s_ > 0) {
    if (const auto range = take(unit_s_, 0)) return range;
  }
  const double middle = Median(sorted_);
  for (const auto& [least, most, unit_s] : kSince1970) {
    if (middle < least || middle >= most) continue;
    if (const auto range = take(unit_s, kShortestPart_s)) return range;
  }
  if (middle >= kNsSince1970) return std::nullopt;
  const bool floating = type == ScalarType::kFloat32 || type == ScalarType::kFloat64;
  for (const double unit_s : kUnits_s) {
    const bool is_usual = unit_s == (floating ? 1.0 : 1e-9);
    if (const auto range = take(unit_s, is_usual ? kShortestPart_s : kShortestTurn_s)) return range;
  }
  return std::nullopt;
}

// The times that are no odd ones, and seconds per unit. Empty where they make no sense.
std::optional<TimeReader::Range> TimeReader::Understand(ScalarType type, double given_s,
                                                        std::vector<double>& times, double* unit) {
  const Range all = RangeOf(times);
  *unit = given_s > 0 ? given_s : unit_s_;
  const double span_s = all.span() * *unit, least_s = given_s > 0 ? kShortestPart_s : 0;
  const double most_s = std::min(kLongerTurn * turn_s_, kLongestTurn_s);
  if (*unit > 0 && turn_s_ > 0 && span_s >= least_s && span_s <= most_s) return all;
  sorted_.clear();
  for (const double t : times) {
    if (!std::isnan(t)) sorted_.push_back(t);
  }
  std::sort(sorted_.begin(), sorted_.end());
  if (const auto most = TakeMost(type, given_s, times, unit)) return most;
  const auto [zero, end] = std::equal_range(sorted_.begin(), sorted_.end(), 0.0);
  const auto zeros = static_cast<double>(end - zero);
  const bool stands = zeros >= kMostShare * static_cast<double>(sorted_.size());
  return stands ? std::optional(Range{}) : std::nullopt;
}

bool TimeReader::Read(ScalarType type, int64_t end_stamp_ns, std::vector<double>& times,
                      double unit_s) {
  if (!FillTimes(type, times)) return false;
  double unit = 0;
  const std::optional<Range> most = Understand(type, unit_s, times, &unit);
  if (!most) return false;
  const Range range = *most;
  if (range.first == 0 && range.last == 0) {
    if (turn_s_ > 0) return false;  // The sensor gave times in other scans.
    unit = 0;
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
  if (std::abs(last_s) > kLongestTurn_s) {  // A clock's: times from a turn's start end with it.
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
