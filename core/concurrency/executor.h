// A fixed number of threads that run tasks, in the order they were posted.
#pragma once

#include <absl/status/status.h>

#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus {

// Thread safe. The destructor runs what was posted, then joins.
class Executor {
 public:
  explicit Executor(int threads);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  // Runs `task` on some thread, in order of posting on an executor of one thread. What a task
  // throws ends that task alone. Callers bound what they post; the executor itself does not refuse.
  void Post(std::function<void()> task);

  // Waits until nothing is queued and nothing runs. Must not be called from a task. Fails with what
  // the first task threw since the last call (CaughtStatus), if one did.
  absl::Status WaitUntilIdle();

 private:
  void Work();

  Mutex mutex_;
  CondVar wake_, idle_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  int running_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status thrown_ ABSL_GUARDED_BY(mutex_);  // By the first since WaitUntilIdle.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;  // Constant after construction.
};

}  // namespace isthmus
