// A counter of events that threads wait on: what changed is looked up elsewhere.
#pragma once

#include <absl/time/time.h>

#include <cstdint>

#include "core/concurrency/mutex.h"

namespace isthmus {

// A waiter reads count(), then looks at what it waits for, then waits past that count: no event in
// between is missed. Thread safe.
class EventCount {
 public:
  uint64_t count() const {
    MutexLock lock(&mutex_);
    return count_;
  }
  void Notify() {
    MutexLock lock(&mutex_);
    ++count_;
    changed_.SignalAll();
  }
  // Until more than so many events came, or until then.
  void WaitPast(uint64_t seen, absl::Time deadline = absl::InfiniteFuture()) const {
    MutexLock lock(&mutex_);
    while (count_ <= seen) {
      if (changed_.WaitWithDeadline(&mutex_, deadline)) return;
    }
  }

 private:
  mutable Mutex mutex_;
  mutable CondVar changed_;
  uint64_t count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus
