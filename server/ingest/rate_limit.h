// A limit on the scans that a session may send in a second.
#pragma once

#include <algorithm>
#include <cstdint>

#include "server/ingest/limits.h"

namespace isthmus::ingest {

// A bucket of scans that fills at a steady rate. Not thread safe.
class RateLimit {
 public:
  // 0: there is none.
  explicit RateLimit(double hz) : hz_(hz) {}

  // True if one more scan is within the limit, by any steady clock.
  bool HasRoom(int64_t now_ns) const { return hz_ <= 0 || ScansAt(now_ns) >= 1; }
  // Counts a scan, within the limit or not.
  void Take(int64_t now_ns) {
    scans_ = ScansAt(now_ns) - 1;
    filled_ns_ = now_ns;
    started_ = true;
  }

 private:
  double ScansAt(int64_t now_ns) const {
    const double most = hz_ * kRateBurstS + 1;
    if (!started_) return most;
    const double passed_s = 1e-9 * static_cast<double>(std::max<int64_t>(now_ns - filled_ns_, 0));
    return std::min(most, scans_ + hz_ * passed_s);
  }

  const double hz_;
  bool started_ = false;
  double scans_ = 0;
  int64_t filled_ns_ = 0;
};

}  // namespace isthmus::ingest
