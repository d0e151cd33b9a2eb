#include "client/readers/folder/name_times.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/time/civil_time.h>
#include <absl/time/time.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "client/readers/limits.h"
#include "core/nanoseconds.h"

namespace isthmus::readers {
namespace {

constexpr char kSecondsAndNanoseconds[] = ", the digits behind the seconds without their zeros";

using Names = std::vector<NameParts>;
using Seconds = std::vector<int64_t>;
using Fractions = std::vector<std::string>;

// The intervals of times that were sorted; empty unless each is later than the one before by what a
// scan takes, mostly.
std::vector<int64_t> Intervals(std::vector<int64_t> times) {
  std::sort(times.begin(), times.end());
  std::vector<int64_t> intervals;
  for (size_t i = 1; i < times.size(); ++i) {
    intervals.push_back(times[i] - times[i - 1]);
    if (intervals.back() <= 0) return {};
  }
  return intervals;
}

int64_t Median(std::vector<int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool AreTimes(const std::vector<int64_t>& times) {
  if (times.size() < 2) return true;
  const std::vector<int64_t> intervals = Intervals(times);
  return !intervals.empty() && Median(intervals) >= kShortestIntervalNs;
}

// Mean distance of intervals from the usual one, as shares of it, at most 1 each: of gaps too.
double Unevenness(const std::vector<int64_t>& times) {
  const std::vector<int64_t> intervals = Intervals(times);
  if (intervals.empty()) return 1;
  const auto median = static_cast<double>(Median(intervals));
  double sum = 0;
  for (const int64_t interval : intervals) {
    sum += std::min(1.0, std::abs(static_cast<double>(interval) / median - 1));
  }
  return sum / static_cast<double>(intervals.size());
}

// Seconds and decimal fractions; digits beyond nanoseconds are cut off.
std::vector<int64_t> AsDecimals(const Seconds& seconds, const Fractions& fractions) {
  std::vector<int64_t> times;
  for (size_t i = 0; i < seconds.size(); ++i) {
    std::string digits = fractions[i];
    digits.resize(9, '0');
    int64_t ns = 0;
    if (!absl::SimpleAtoi(digits, &ns)) return {};
    times.push_back(seconds[i] * kNsPerSecond + ns);
  }
  return times;
}

// Seconds and what has that many digits at most: milli-, micro- or nanoseconds.
std::vector<int64_t> AsCounts(const Seconds& seconds, const Fractions& fractions, size_t digits) {
  if (digits > 9) return {};
  const int64_t unit_ns = digits <= 3 ? 1'000'000 : digits <= 6 ? 1'000 : 1;
  std::vector<int64_t> times;
  for (size_t i = 0; i < seconds.size(); ++i) {
    int64_t count = 0;
    if (!fractions[i].empty() && !absl::SimpleAtoi(fractions[i], &count)) return {};
    times.push_back(seconds[i] * kNsPerSecond + count * unit_ns);
  }
  return times;
}

std::optional<NameTimes> Accept(std::vector<int64_t> times, std::string reading) {
  if (times.empty() || !AreTimes(times)) return std::nullopt;
  if (*std::max_element(times.begin(), times.end()) > kLatestStampNs) return std::nullopt;
  return NameTimes{std::move(times), std::move(reading)};
}

std::optional<NameTimes> WithFractions(const Seconds& seconds, const Fractions& fractions,
                                       const std::string& reading) {
  size_t least = fractions.front().size(), most = least;
  bool padded = false, cut = true;
  for (const std::string& digits : fractions) {
    least = std::min(least, digits.size());
    most = std::max(most, digits.size());
    padded = padded || (digits.size() > 1 && digits.front() == '0');
    cut = cut && (digits.size() < 2 || digits.back() != '0');
  }
  std::vector<int64_t> decimals = AsDecimals(seconds, fractions);
  if (least == most || padded) return Accept(std::move(decimals), reading);
  std::vector<int64_t> counts = AsCounts(seconds, fractions, most);
  if (cut && (counts.empty() || Unevenness(decimals) <= Unevenness(counts))) {
    return Accept(std::move(decimals), reading);
  }
  return Accept(std::move(counts), absl::StrCat(reading, kSecondsAndNanoseconds));
}

// The k-th number of every name as a whole number; empty where one is too long.
std::vector<int64_t> Whole(const Names& names, size_t k) {
  std::vector<int64_t> values;
  for (const NameParts& name : names) {
    if (!absl::SimpleAtoi(name.numbers[k].digits, &values.emplace_back())) return {};
  }
  return values;
}

Fractions FractionsOf(const Names& names, size_t k) {
  Fractions fractions;
  for (const NameParts& name : names) fractions.push_back(name.numbers[k].fraction);
  return fractions;
}

bool HasFractions(const Names& names, size_t k) {
  return std::any_of(names.begin(), names.end(),
                     [&](const NameParts& name) { return !name.numbers[k].fraction.empty(); });
}

// The digits of the next number, where they stand for the fraction of the k-th: "29-468".
std::optional<Fractions> FractionBehind(const Names& names, size_t k, size_t least_digits) {
  if (k + 1 >= names.front().numbers.size() || HasFractions(names, k + 1)) return std::nullopt;
  const std::string& between = names.front().texts[k + 1];
  if (between != "_" && between != "-") return std::nullopt;
  Fractions fractions;
  size_t most = 0;
  for (const NameParts& name : names) {
    fractions.push_back(name.numbers[k + 1].digits);
    most = std::max(most, fractions.back().size());
  }
  return most >= least_digits && most <= 9 ? std::optional(fractions) : std::nullopt;
}

// Nanoseconds of the last digit of a Unix time, by the number of digits; 0: it is none.
int64_t UnitOf(size_t digits) {
  switch (digits) {
    case 10:
      return kNsPerSecond;
    case 13:
      return 1'000'000;
    case 16:
      return 1'000;
    case 19:
      return 1;
    default:
      return 0;
  }
}

std::optional<NameTimes> UnixTimes(const Names& names, size_t k) {
  const std::vector<int64_t> values = Whole(names, k);
  std::vector<int64_t> times;
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t digits = names[i].numbers[k].digits.size();
    const int64_t unit_ns = UnitOf(digits);
    if (unit_ns == 0 || digits != names.front().numbers[k].digits.size()) return std::nullopt;
    if (values[i] > kLatestStampNs / unit_ns) return std::nullopt;
    times.push_back(values[i] * unit_ns);
    if (static_cast<double>(times.back()) < 1e9 * kUnixTimeS) return std::nullopt;
  }
  if (times.empty()) return std::nullopt;
  if (names.front().numbers[k].digits.size() != 10) return Accept(std::move(times), "");
  if (HasFractions(names, k)) return WithFractions(values, FractionsOf(names, k), "");
  if (const auto behind = FractionBehind(names, k, 6)) {
    if (auto read = WithFractions(values, *behind, "")) return read;
  }
  return Accept(std::move(times), "");
}

// The second that the numbers from the k-th on tell, and which number is the last of them.
std::optional<std::pair<int64_t, size_t>> DateAt(const NameParts& name, size_t k) {
  // Written together, or each apart.
  std::string digits;
  size_t last = k;
  for (; last < name.numbers.size(); ++last) {
    const std::string& number = name.numbers[last].digits;
    digits += number.size() == 1 ? absl::StrCat("0", number) : number;
    if (digits.size() >= 14 || !name.numbers[last].fraction.empty()) break;
  }
  if (digits.size() != 14) return std::nullopt;
  const auto part = [&](size_t at, size_t size) {
    int value = 0;
    return absl::SimpleAtoi(digits.substr(at, size), &value) ? value : -1;
  };
  const int year = part(0, 4), month = part(4, 2), day = part(6, 2);
  const int hour = part(8, 2), minute = part(10, 2), second = part(12, 2);
  const absl::CivilSecond date(year, month, day, hour, minute, second);
  // CivilSecond makes a date even of numbers that are none.
  if (year < 1990 || year > 2100 || date.month() != month || date.day() != day ||
      date.hour() != hour || date.minute() != minute || date.second() != second) {
    return std::nullopt;
  }
  return std::pair(absl::ToUnixSeconds(absl::FromCivil(date, absl::UTCTimeZone())), last);
}

std::optional<NameTimes> Dates(const Names& names, size_t k) {
  constexpr char kUtc[] = ", taken for UTC";
  Seconds seconds;
  size_t last = 0;
  for (const NameParts& name : names) {
    const auto date = DateAt(name, k);
    if (!date || (!seconds.empty() && date->second != last)) return std::nullopt;
    seconds.push_back(date->first);
    last = date->second;
  }
  if (HasFractions(names, last)) return WithFractions(seconds, FractionsOf(names, last), kUtc);
  if (const auto behind = FractionBehind(names, last, 3)) {
    if (auto read = WithFractions(seconds, *behind, kUtc)) return read;
  }
  for (int64_t& s : seconds) s *= kNsPerSecond;
  return Accept(std::move(seconds), kUtc);
}

std::optional<NameTimes> SimulatedSeconds(const Names& names, size_t k) {
  if (names.size() < 2 || !HasFractions(names, k)) return std::nullopt;
  const Seconds seconds = Whole(names, k);
  if (seconds.empty() || *std::max_element(seconds.begin(), seconds.end()) > kUnixTimeS) {
    return std::nullopt;
  }
  return WithFractions(seconds, FractionsOf(names, k), "");
}

std::optional<NameTimes> SimulatedNanoseconds(const Names& names, size_t k) {
  std::vector<int64_t> values = Whole(names, k);
  if (values.size() < 2 || HasFractions(names, k)) return std::nullopt;
  const std::vector<int64_t> intervals = Intervals(values);
  if (intervals.empty()) return std::nullopt;
  const int64_t usual = Median(intervals);
  const auto between_scans = [&](int64_t unit_ns) {
    return usual >= kLeastStepNs / unit_ns && usual <= kMostStepNs / unit_ns;
  };
  if (between_scans(1)) return Accept(std::move(values), " in nanoseconds");
  if (!between_scans(1'000)) return std::nullopt;
  for (int64_t& value : values) {
    if (value > kLatestStampNs / 1'000) return std::nullopt;
    value *= 1'000;
  }
  return Accept(std::move(values), " in microseconds");
}

std::optional<NameTimes> TimesOf(const Names& names) {
  if (names.empty()) return std::nullopt;
  for (const auto& read : {UnixTimes, Dates, SimulatedSeconds, SimulatedNanoseconds}) {
    for (size_t k = 0; k < names.front().numbers.size(); ++k) {
      if (auto times = read(names, k)) return times;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<NameTimes> OrderByTimes(NameSeries& series) {
  std::optional<NameTimes> times = TimesOf(series.parts);
  if (!times) return std::nullopt;
  std::vector<size_t> by_time(times->stamps_ns.size());
  std::iota(by_time.begin(), by_time.end(), size_t{0});
  std::sort(by_time.begin(), by_time.end(),
            [&](size_t a, size_t b) { return times->stamps_ns[a] < times->stamps_ns[b]; });
  NameSeries sorted = series;
  for (size_t i = 0; i < by_time.size(); ++i) {
    sorted.order[i] = series.order[by_time[i]];
    sorted.parts[i] = series.parts[by_time[i]];
  }
  series = std::move(sorted);
  std::sort(times->stamps_ns.begin(), times->stamps_ns.end());
  return times;
}

}  // namespace isthmus::readers
