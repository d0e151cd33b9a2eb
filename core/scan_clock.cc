#include "core/scan_clock.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

namespace isthmus {
namespace {

// The year 2116; no difference below overflows.
constexpr int64_t kLatest_ns = int64_t{1} << 62;

}  // namespace

absl::StatusOr<ScanClock::Reading> ScanClock::Read(int64_t end_stamp_ns) {
  if (end_stamp_ns >= kLatest_ns || end_stamp_ns <= -kLatest_ns) {
    return absl::InvalidArgumentError(
        absl::StrCat("the scan's stamp, ", end_stamp_ns, ", is no time in nanoseconds since 1970"));
  }
  if (!started_) return Reading{end_stamp_ns, false};
  const int64_t between_ns = end_stamp_ns - stamp_ns_;
  if (between_ns > 0) {
    return Reading{time_ns_ + std::min(between_ns, kMaxStep_ns), between_ns > kMaxStep_ns};
  }
  if (has_refused_ && end_stamp_ns > refused_ns_) {
    const int64_t since_ns = std::min(end_stamp_ns - refused_ns_, kMaxStep_ns - interval_ns_);
    return Reading{time_ns_ + interval_ns_ + since_ns, true};
  }
  has_refused_ = true;
  refused_ns_ = end_stamp_ns;
  return absl::InvalidArgumentError(
      absl::StrCat("the scan's stamp, ", end_stamp_ns, " ns, is ", -(between_ns / 1'000'000),
                   " ms before that of the scan before it: sent twice or out of order; if the "
                   "clock was set back, "
                   "the next scan is taken"));
}

void ScanClock::Advance(int64_t end_stamp_ns, int64_t time_ns) {
  const int64_t interval_ns = time_ns - time_ns_;
  if (started_ && !has_refused_ && interval_ns <= kMaxInterval_ns) interval_ns_ = interval_ns;
  started_ = true;
  has_refused_ = false;
  stamp_ns_ = end_stamp_ns;
  time_ns_ = time_ns;
}

}  // namespace isthmus
