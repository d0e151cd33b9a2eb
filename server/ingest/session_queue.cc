// The queue of a session: the scans that may wait, and those that are skipped.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/codec/payload_layout.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/limits.h"
#include "server/ingest/session_worker.h"

namespace isthmus::ingest {

WaitingScan SessionWorker::Examine(ScanUpload scan) const {
  WaitingScan waiting{std::move(scan)};
  const uint64_t points = codec::PointCount(waiting.scan.payload);
  if (points <= options_.max_points) return waiting;
  waiting.refused = absl::StrCat(
      "the scan has ", points, " points, more than the ", options_.max_points,
      " that this server takes: send one turn of the sensor per scan, thin it out, or raise "
      "ingest.max_scan_points");
  return waiting;
}

absl::Status SessionWorker::ClosedError() const {
  return absl::UnavailableError(absl::StrCat("session ", record_.id.value(),
                                             " takes no scans at the moment: it is being closed"));
}

bool SessionWorker::IsFull(size_t more_bytes) const {
  if (queue_.length() >= options_.queue + kMaxSkipped) return true;
  if (queue_.waiting() >= options_.queue) return true;
  return queue_.waiting() > 0 && queue_.bytes() + more_bytes > options_.queue_bytes;
}

absl::StatusOr<bool> SessionWorker::MakeRoom(const WaitingScan& scan, bool waits) {
  const size_t bytes = scan.bytes();
  while (!stopping_ && IsFull(bytes)) {
    const bool may_skip = KeepsNewest() && queue_.length() < options_.queue + kMaxSkipped;
    if (const size_t freed = may_skip ? queue_.SkipOldest() : 0; freed > 0) {
      options_.room->Give(freed);
    } else if (waits) {
      changed_.Wait(&mutex_);
    } else {
      return false;
    }
  }
  if (stopping_) return ClosedError();
  return waits || KeepsNewest() || rate_.HasRoom(options_.now_ns());
}

bool SessionWorker::TakeSharedRoom(WaitingScan* scan) {
  if (KeepsNewest() && !rate_.HasRoom(options_.now_ns())) {
    scan->scan.payload = PointPayload();
    scan->is_skipped = true;
  }
  while (!options_.room->TryTake(scan->bytes(), queue_.waiting() == 0)) {
    if (!KeepsNewest()) return false;
    if (const size_t freed = queue_.SkipOldest(); freed > 0) {
      options_.room->Give(freed);
      continue;
    }
    // Others take all there is: this one gives way.
    scan->scan.payload = PointPayload();
    scan->is_skipped = true;
  }
  return true;
}

void SessionWorker::Enqueue(WaitingScan scan) {
  const uint64_t sequence = scan.scan.sequence;
  if (!scan.refused.empty()) scan.scan.payload = PointPayload();
  scan.received_ns = options_.clock->NowNs();
  if (sequence > last_submitted_) {
    if (!scan.is_skipped) rate_.Take(options_.now_ns());
    pace_.NoteScan(scan.scan.end_stamp_ns, options_.now_ns());
    executor_->SetCharge(*lane_, pace_.IsBackfill() ? kBackfillCharge : 1);
  }
  // In this order because any of it may throw; the task waits for the lock.
  if (!running_) {
    executor_->Post(lane_, [self = shared_from_this()] { self->RunOne(); });
    running_ = true;
  }
  if (sequence > last_submitted_) {
    received_ns_ = scan.received_ns;
    times_.Note(sequence, received_ns_);
  }
  queue_.Push(std::move(scan));
  last_submitted_ = std::max(last_submitted_, sequence);
}

bool SessionWorker::TakeScan(WaitingScan* scan) {
  MutexLock lock(&mutex_);
  if (queue_.empty()) return false;
  *scan = queue_.Pop();
  changed_.SignalAll();
  return true;
}

size_t SessionWorker::ClearQueue() {
  const size_t dropped = queue_.length();
  options_.room->Give(queue_.bytes());
  queue_.Clear();
  changed_.SignalAll();
  return dropped;
}

}  // namespace isthmus::ingest
