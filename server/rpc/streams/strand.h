// A line of tasks of one owner, which an executor runs one at a time and in order.
#pragma once

#include <deque>
#include <functional>
#include <memory>

#include "core/concurrency/executor.h"
#include "core/concurrency/mutex.h"

namespace isthmus::rpc {

// Between two tasks others of the executor have their turn. Thread safe; made by std::make_shared.
class Strand : public std::enable_shared_from_this<Strand> {
 public:
  // The executor must outlive it.
  explicit Strand(Executor* executor) : executor_(*executor) {}

  // Never waits. What a task throws ends that task alone.
  void Post(std::function<void()> task);

 private:
  void RunOne();

  Executor& executor_;
  Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool running_ ABSL_GUARDED_BY(mutex_) = false;  // Posted to the executor, or at work.
};

}  // namespace isthmus::rpc
