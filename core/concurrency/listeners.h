// A list of callbacks that are told of news.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus {

// A listener must not block. One last call of it may be under way when Remove returns. Thread safe.
class Listeners {
 public:
  // Returns the handle that Remove takes.
  uint64_t Add(std::function<void()> listener) {
    MutexLock lock(&mutex_);
    listeners_.emplace(next_handle_, std::move(listener));
    return next_handle_++;
  }
  void Remove(uint64_t handle) {
    Map::node_type gone;  // Its captures are let go of without the lock.
    MutexLock lock(&mutex_);
    gone = listeners_.extract(handle);
  }
  // Calls each of them, from this thread.
  void Tell() const {
    std::vector<std::function<void()>> listeners;
    {
      MutexLock lock(&mutex_);
      for (const auto& [handle, listener] : listeners_) listeners.push_back(listener);
    }
    for (const auto& listener : listeners) listener();
  }

 private:
  using Map = std::map<uint64_t, std::function<void()>>;

  mutable Mutex mutex_;
  uint64_t next_handle_ ABSL_GUARDED_BY(mutex_) = 1;
  Map listeners_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus
