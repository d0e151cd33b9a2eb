#include "server/ingest/scan_times.h"

#include <algorithm>

#include "server/ingest/limits.h"

namespace isthmus::ingest {

void ScanTimes::Note(uint64_t sequence, int64_t now_ns) {
  if (times_.size() >= kMaxScanTimes) {
    size_t kept = 0;
    for (size_t i = 0; i < times_.size(); i += 2) times_[kept++] = times_[i];
    times_.resize(kept);
  }
  times_.push_back({sequence, now_ns});
}

void ScanTimes::ForgetUpTo(uint64_t sequence, const std::function<void(int64_t ns)>& forget) {
  const auto is_over = [&] {
    return times_.size() > 1 ? times_[1].sequence <= sequence + 1
                             : !times_.empty() && times_.front().sequence <= sequence;
  };
  for (; is_over(); times_.pop_front()) {
    if (forget) forget(times_.front().ns);
  }
}

int64_t ScanTimes::Of(uint64_t sequence) const {
  const auto next =
      std::upper_bound(times_.begin(), times_.end(), sequence,
                       [](uint64_t wanted, const Time& time) { return wanted < time.sequence; });
  return next == times_.begin() ? 0 : std::prev(next)->ns;
}

}  // namespace isthmus::ingest
