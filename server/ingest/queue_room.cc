#include "server/ingest/queue_room.h"

#include <algorithm>

#include "server/ingest/limits.h"

namespace isthmus::ingest {

bool QueueRoom::TryTake(size_t bytes, bool first) {
  MutexLock lock(&mutex_);
  const bool has_room = HasRoom(bytes, first);
  if (has_room) used_ += bytes;
  return has_room;
}

bool QueueRoom::WouldTake(size_t bytes, bool first) const {
  MutexLock lock(&mutex_);
  return HasRoom(bytes, first);
}

bool QueueRoom::HasRoom(size_t bytes, bool first) const {
  return used_ + bytes <= limit_ || (first && (bytes <= kSmallScanBytes || used_ == 0));
}

void QueueRoom::Give(size_t bytes) {
  {
    MutexLock lock(&mutex_);
    used_ -= std::min(bytes, used_);
  }
  freed_.Notify();
}

size_t QueueRoom::used() const {
  MutexLock lock(&mutex_);
  return used_;
}

}  // namespace isthmus::ingest
