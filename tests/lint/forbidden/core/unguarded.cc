#include "core/concurrency/mutex.h"

class Counter {
 public:
  int count() const { return count_; }

 private:
  mutable isthmus::Mutex mutex_;
  int count_ ABSL_GUARDED_BY(mutex_) = 0;
};
