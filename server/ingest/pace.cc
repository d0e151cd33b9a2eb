#include "server/ingest/pace.h"

#include <algorithm>

#include "core/scan_clock.h"
#include "server/ingest/limits.h"

namespace isthmus::ingest {

void Pace::NoteScan(int64_t end_stamp_ns, int64_t now_ns) {
  if (started_) {
    // Stamps that jump say nothing; no difference overflows that is used.
    const bool is_step =
        end_stamp_ns > stamp_ns_ && end_stamp_ns / 2 - stamp_ns_ / 2 < ScanClock::kMaxStep_ns;
    const int64_t stamps_ns =
        is_step ? std::min(end_stamp_ns - stamp_ns_, ScanClock::kMaxInterval_ns) : 0;
    const int64_t passed_ns = std::clamp<int64_t>(now_ns - now_ns_, 0, ScanClock::kMaxStep_ns);
    lead_ns_ = std::clamp<int64_t>(lead_ns_ + stamps_ns - passed_ns, 0, kMaxLead_ns);
  }
  started_ = true;
  stamp_ns_ = end_stamp_ns;
  now_ns_ = now_ns;
  if (lead_ns_ >= kBackfillLead_ns) is_backfill_ = true;
  if (lead_ns_ == 0) is_backfill_ = false;
}

}  // namespace isthmus::ingest
