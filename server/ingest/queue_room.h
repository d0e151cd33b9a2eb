// The memory that the scans of all sessions that wait may take together.
#pragma once

#include <cstddef>

#include "core/concurrency/event_count.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/limits.h"

namespace isthmus::ingest {

// Thread safe.
class QueueRoom {
 public:
  explicit QueueRoom(size_t bytes) : limit_(bytes) {}

  // Takes so many bytes if there is room. A scan that finds none of its session's before it is
  // `first`: where it is small it always has room, so that those who send much shut nobody out; and
  // where nothing else waits, whatever its size.
  bool TryTake(size_t bytes, bool first);
  void Give(size_t bytes);

  size_t used() const;
  size_t limit() const { return limit_; }
  // The part of one session.
  size_t session_limit() const { return limit_ / kSessionsAtTheirMost; }
  // Notified when room was given back.
  EventCount& freed() { return freed_; }

 private:
  const size_t limit_;
  mutable Mutex mutex_;
  size_t used_ ABSL_GUARDED_BY(mutex_) = 0;
  EventCount freed_;
};

}  // namespace isthmus::ingest
