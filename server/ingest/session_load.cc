// A session's load: the scans that wait, and the progress of all its scans.
#include <algorithm>

#include "core/concurrency/mutex.h"
#include "server/ingest/session_worker.h"

namespace isthmus::ingest {

void SessionWorker::NoteAcknowledged(const WaitingScan& waiting) {
  MutexLock lock(&mutex_);
  if (waiting.scan.sequence <= acknowledged_) return;
  acknowledged_ = waiting.scan.sequence;
  ack_delay_ns_ = std::max<int64_t>(0, options_.clock->NowNs() - waiting.received_ns);
}

SessionLoad SessionWorker::Load() const {
  MutexLock lock(&mutex_);
  SessionLoad load;
  load.session = record_.id;
  load.robot = record_.robot;
  load.waiting_scans = queue_.waiting();
  load.waiting_bytes = queue_.bytes();
  load.received_sequence = last_submitted_;
  load.acknowledged_sequence = acknowledged_;
  load.durable_sequence = status_.durable_sequence;
  load.received_ns = received_ns_;
  load.ack_delay_ns = ack_delay_ns_;
  // A scan may be durable a moment before it is acknowledged; its time is gone then.
  const uint64_t settled = std::max(acknowledged_, status_.durable_sequence);
  if (settled < last_submitted_) load.oldest_unacknowledged_ns = times_.Of(settled + 1);
  if (status_.durable_sequence < last_submitted_) {
    load.oldest_undurable_ns = times_.Of(status_.durable_sequence + 1);
  }
  load.scans_processed = status_.processed;
  load.scans_rejected = status_.rejected;
  load.scans_skipped = status_.scans.skipped;
  load.tracking = status_.tracking;
  load.lost_since_ns = status_.lost_since_ns;
  load.newest = newest_;
  load.newest_segment = newest_segment_;
  return load;
}

}  // namespace isthmus::ingest
