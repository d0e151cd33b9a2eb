#include "server/ingest/scan_clock.h"

#include <absl/strings/str_cat.h>

#include "server/ingest/limits.h"

namespace isthmus::ingest {

absl::StatusOr<ScanClock::Reading> ScanClock::Read(int64_t end_stamp_ns) const {
  // The year 2116; no difference below overflows.
  constexpr int64_t kLatest_ns = int64_t{1} << 62;
  if (end_stamp_ns > kLatest_ns || end_stamp_ns < -kLatest_ns) {
    return absl::InvalidArgumentError(
        absl::StrCat("the scan's stamp, ", end_stamp_ns, ", is no time in nanoseconds since 1970"));
  }
  if (!started_) return Reading{end_stamp_ns, false};
  const int64_t between_ns = end_stamp_ns - stamp_ns_;
  if (between_ns < -kOutOfOrder_ns) return Reading{time_ns_ + interval_ns_, true};
  if (between_ns <= 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the scan's stamp, ", end_stamp_ns, " ns, is ", -between_ns / 1'000'000,
        " ms before that of the scan before it: sent twice or out of order; scans must come in "
        "order of time"));
  }
  // A pause of a minute or of a year is the same to the odometry.
  const int64_t forward_ns = between_ns > kMaxStep_ns ? kMaxStep_ns : between_ns;
  return Reading{time_ns_ + forward_ns, between_ns > kMaxStep_ns};
}

void ScanClock::Advance(int64_t end_stamp_ns, int64_t time_ns) {
  const int64_t interval_ns = time_ns - time_ns_;
  if (started_ && interval_ns <= kMaxInterval_ns) interval_ns_ = interval_ns;
  started_ = true;
  stamp_ns_ = end_stamp_ns;
  time_ns_ = time_ns;
}

}  // namespace isthmus::ingest
