#include "server/ingest/queue_room.h"

#include <algorithm>

#include "server/ingest/limits.h"

namespace isthmus::ingest {

bool QueueRoom::TryTake(size_t bytes, bool first) {
  MutexLock lock(&mutex_);
  const bool always = first && (bytes <= kSmallScanBytes || used_ == 0);
  if (!always && used_ + bytes > limit_) return false;
  used_ += bytes;
  return true;
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
