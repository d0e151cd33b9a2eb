#include "server/ingest/scan_queue.h"

#include <utility>

namespace isthmus::ingest {

size_t WaitingScan::bytes() const {
  if (!refused.empty()) return sizeof(WaitingScan);
  return sizeof(WaitingScan) + scan.payload.data.size() +
         scan.payload.fields.size() * sizeof(PointField);
}

void ScanQueue::Push(WaitingScan scan) {
  bytes_ += scan.bytes();
  skipped_ += scan.is_skipped ? 1 : 0;
  scans_.push_back(std::move(scan));
}

WaitingScan ScanQueue::Pop() {
  WaitingScan scan = std::move(scans_.front());
  scans_.pop_front();
  bytes_ -= scan.bytes();
  skipped_ -= scan.is_skipped ? 1 : 0;
  return scan;
}

size_t ScanQueue::SkipOldest() {
  for (WaitingScan& scan : scans_) {
    if (scan.is_skipped) continue;
    const size_t before = scan.bytes();
    scan.scan.payload = PointPayload();
    scan.is_skipped = true;
    ++skipped_;
    const size_t freed = before - scan.bytes();
    bytes_ -= freed;
    return freed;
  }
  return 0;
}

void ScanQueue::Clear() {
  scans_.clear();
  skipped_ = bytes_ = 0;
}

}  // namespace isthmus::ingest
