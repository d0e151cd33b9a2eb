// Arrival times of a session's scans that somebody still waits for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>

namespace isthmus::ingest {

// Holds kMaxScanTimes at most: where more would come every second one is let go of, and such a scan
// is said to have come with the one before it. Not thread safe.
class ScanTimes {
 public:
  // Notes a scan newer than all before.
  void Note(uint64_t sequence, int64_t now_ns);
  // Calls `forget` with the time of each, if it is not null.
  void ForgetUpTo(uint64_t sequence, const std::function<void(int64_t ns)>& forget = nullptr);
  // When the scan came; 0 where that was before the first that is known.
  int64_t Of(uint64_t sequence) const;

  size_t size() const { return times_.size(); }

 private:
  struct Time {
    uint64_t sequence = 0;
    int64_t ns = 0;
  };
  std::deque<Time> times_;  // In order; each holds up to the next.
};

}  // namespace isthmus::ingest
