#include "client/readers/stamps.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "client/readers/limits.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/ring_lines.h"
#include "core/codec/time_field.h"

namespace isthmus::readers {
namespace {

using Zero = codec::TimeReader::Zero;

// Nanoseconds after which a counter of 32 bits starts again.
constexpr int64_t kCounterTurnNs = int64_t{1} << 32;  // Format

constexpr char kOtherClock[] =
    "the clock of the points is not that of the headers: the first header's stamp is taken for the "
    "END of its scan, and the points' clock tells how much later the others ended";

int64_t ToNs(double seconds) { return std::llround(seconds * 1e9); }

// Keeps the times of returns alone.
void KeepReturns(const PointPayload& payload, std::vector<double>& times) {
  std::vector<ScanPoint> points(times.size());
  const std::pair<const char*, float ScanPoint::*> axes[] = {
      {"x", &ScanPoint::x}, {"y", &ScanPoint::y}, {"z", &ScanPoint::z}};
  for (const auto& [name, axis] : axes) {
    const PointField* field = codec::FindField(payload, {name});
    if (field == nullptr) return times.clear();
    codec::ForEachValue(payload, *field, [&points, axis = axis](uint64_t i, auto value) {
      points[i].*axis = static_cast<float>(value);
    });
  }
  size_t kept = 0;
  for (size_t i = 0; i < times.size(); ++i) {
    if (codec::IsReturn(points[i])) times[kept++] = times[i];
  }
  times.resize(kept);
}

// A hash of bytes here and there, which differ in any two scans of a sensor.
size_t Fingerprint(absl::string_view data) {
  constexpr size_t kPieces = 64, kPiece = 64;
  size_t sum = data.size();
  for (size_t i = 0; i < kPieces; ++i) {
    const size_t at = i * (data.size() / kPieces);
    sum = 31 * sum + std::hash<std::string_view>()(
                         std::string_view(data.data(), data.size()).substr(at, kPiece));
  }
  return sum;
}

}  // namespace

void ScanStamps::Assume(absl::string_view sentence) {
  if (std::find(assumptions_.begin(), assumptions_.end(), sentence) == assumptions_.end()) {
    assumptions_.emplace_back(sentence);
  }
}

std::optional<ScanStamps::Times> ScanStamps::ReadTimes(const PointPayload& payload,
                                                       int64_t header_ns) {
  std::optional<codec::TimeField> field = codec::ReadTimeField(payload);
  if (!field) return std::nullopt;
  KeepReturns(payload, field->values);
  if (!reader_.Read(field->type, header_ns, field->values, field->unit_s)) return std::nullopt;
  const codec::TimeReader::Reading& last = reader_.last();
  Times read{last.first_s, last.end_s, reader_.memory().zero,
             field->type == ScalarType::kUint32 && last.unit_s == 1e-9};
  // No instant that a stamp can be, nor a difference to one.
  const bool is_clock = read.zero == Zero::kClock;
  if (std::abs(read.end_s) > 1e-9 * kLatestStampNs || (is_clock && read.end_s < 0)) {
    return std::nullopt;
  }
  return read;
}

int64_t ScanStamps::ByClock(const Times& times, int64_t header_ns) {
  const int64_t clock_end_ns = ToNs(times.end_s);
  if (times.counts_ns) return ByCounter(clock_end_ns, header_ns);
  if (std::llabs(clock_end_ns - header_ns) <= kSameClockNs) {
    Assume("stamps are those of the points' clock: its latest time is the END of a scan");
    return clock_end_ns;
  }
  if (!clock_offset_ns_ ||
      std::llabs(clock_end_ns + *clock_offset_ns_ - header_ns) > kSameClockNs) {
    clock_offset_ns_ = header_ns - clock_end_ns;
  }
  Assume(kOtherClock);
  return clock_end_ns + *clock_offset_ns_;
}

int64_t ScanStamps::ByCounter(int64_t counter_end_ns, int64_t header_ns) {
  // A counter of the second stays below a second and the length of a scan.
  if (counter_end_ns > 2'000'000'000) counter_turn_ns_ = kCounterTurnNs;
  if (!clock_offset_ns_) clock_offset_ns_ = header_ns - counter_end_ns;
  Assume(kOtherClock);
  const int64_t end_ns = counter_end_ns + *clock_offset_ns_;
  const double turns =
      static_cast<double>(header_ns - end_ns) / static_cast<double>(counter_turn_ns_);
  return end_ns + std::llround(turns) * counter_turn_ns_;
}

std::optional<int64_t> ScanStamps::ByOwnClock(const PointPayload& payload) {
  const std::optional<Times> times = ReadTimes(payload, 0);
  const bool is_clock = times && times->zero == Zero::kClock && !times->counts_ns;
  if (!is_clock || (!clock_offset_ns_ && times->end_s < kUnixTimeS)) return std::nullopt;
  Assume("nothing stamps the scans: the latest time of the points' clock is the END of a scan");
  return ToNs(times->end_s) + clock_offset_ns_.value_or(0);
}

int64_t ScanStamps::WithoutHeader(const PointPayload& payload, int64_t log_ns) {
  if (const std::optional<int64_t> end_ns = ByOwnClock(payload)) return *end_ns;
  Assume("headers have no stamps: the times of recording are taken for the END of scans");
  return log_ns;
}

int64_t ScanStamps::Guess(const PointPayload& payload, int64_t header_ns, int64_t log_ns) {
  if (header_ns <= 0 || header_ns > kLatestStampNs) return WithoutHeader(payload, log_ns);
  if (meaning_ == StampMeaning::kEnd) return header_ns;
  const std::optional<Times> times = ReadTimes(payload, header_ns);
  if (!times && !last_times_) {
    if (meaning_ == StampMeaning::kStart) {
      Assume(absl::StrCat("points have no times: a scan is taken to end ", 1 / rate_hz_,
                          " s behind its stamp"));
      return header_ns + ToNs(1 / rate_hz_);
    }
    Assume("stamps are taken for the END of scans: points have no times");
    return header_ns;
  }
  // A scan whose times cannot be understood lasts as long as the one before.
  const Times known = times ? *times : *last_times_;
  const bool is_clock = known.zero == Zero::kClock;
  if (times) {
    last_times_ = times;
    if (is_clock) {
      // They do not fit another header's stamp, and only tell how long a scan takes.
      last_times_->first_s -= last_times_->end_s;
      last_times_->end_s = 0;
    }
  }
  if (known.zero == Zero::kInstant) return header_ns;
  if (meaning_ == StampMeaning::kStart) {
    const bool from_start = known.zero == Zero::kStart;
    return header_ns + ToNs(from_start ? known.end_s : known.end_s - known.first_s);
  }
  if (is_clock && times) return ByClock(known, header_ns);
  if (known.zero == Zero::kStart) {
    Assume("stamps are taken for the START of scans: the times of points count from there");
  } else if (known.zero == Zero::kEnd) {
    Assume("stamps are taken for the END of scans: the times of points count up to there");
  }
  return header_ns + ToNs(known.end_s);
}

void ScanStamps::LookForStandstill(const Arrival& now, int64_t end_ns) {
  const std::optional<Arrival> before = std::exchange(last_arrival_, now);
  // A message that was sent twice holds the same points.
  const bool stands = before && last_end_ns_ && end_ns <= *last_end_ns_ && now.header_ns > 0 &&
                      now.header_ns == before->header_ns && now.log_ns > before->log_ns &&
                      now.points != before->points;
  if (!stands || log_offset_ns_) return;
  log_offset_ns_ = *last_end_ns_ - before->log_ns;
  Assume(
      "headers' stamps stand still: the times of recording tell how much later scans ended than "
      "the "
      "one before");
}

int64_t ScanStamps::End(const PointPayload& payload, int64_t header_ns, int64_t log_ns) {
  int64_t end_ns = Guess(payload, header_ns, log_ns);
  LookForStandstill({header_ns, log_ns, Fingerprint(payload.data)}, end_ns);
  if (log_offset_ns_) end_ns = log_ns + *log_offset_ns_;
  last_end_ns_ = end_ns;
  return end_ns;
}

}  // namespace isthmus::readers
