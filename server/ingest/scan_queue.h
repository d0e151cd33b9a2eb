// The scans of one session that wait, bounded in number and in bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "core/scan_upload.h"

namespace isthmus::ingest {

// A scan, or what is left of one that is not to be used.
struct WaitingScan {
  ScanUpload scan;
  // Why it is rejected without a look at its points, which do not count: they are gone once it
  // waits.
  std::string refused = {};
  bool is_skipped = false;  // Its points are gone.
  int64_t received_ns = 0;  // The server's clock.

  size_t bytes() const;
};

// Not thread safe. A skipped scan keeps its place, so that acknowledgements stay in order.
class ScanQueue {
 public:
  bool empty() const { return scans_.empty(); }
  size_t length() const { return scans_.size(); }  // Skipped ones included.
  size_t waiting() const { return scans_.size() - skipped_; }
  size_t bytes() const { return bytes_; }

  void Push(WaitingScan scan);
  WaitingScan Pop();  // The oldest; there must be one.
  // Lets go of the points of the oldest scan that is not skipped yet. The bytes that this frees; 0
  // where there is none.
  size_t SkipOldest();
  void Clear();

 private:
  std::deque<WaitingScan> scans_;  // The skipped ones first.
  size_t skipped_ = 0, bytes_ = 0;
};

}  // namespace isthmus::ingest
