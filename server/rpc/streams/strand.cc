#include "server/rpc/streams/strand.h"

#include <absl/cleanup/cleanup.h>

#include <utility>

namespace isthmus::rpc {

void Strand::Post(std::function<void()> task) {
  MutexLock lock(&mutex_);
  tasks_.push_back(std::move(task));
  if (running_) return;
  executor_.Post([self = shared_from_this()] { self->RunOne(); });
  running_ = true;
}

void Strand::RunOne() {
  std::function<void()> task;
  {
    MutexLock lock(&mutex_);
    task = std::move(tasks_.front());
    tasks_.pop_front();
  }
  const absl::Cleanup next = [this] {
    MutexLock lock(&mutex_);
    running_ = !tasks_.empty();
    if (running_) executor_.Post([self = shared_from_this()] { self->RunOne(); });
  };
  task();
  task = nullptr;  // Its captures go outside of the lock.
}

}  // namespace isthmus::rpc
