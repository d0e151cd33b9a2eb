#include "core/concurrency/executor.h"

#include <utility>

#include "core/caught.h"

namespace isthmus {

Executor::Executor(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

Executor::~Executor() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  wake_.SignalAll();
  for (std::thread& thread : threads_) thread.join();
}

void Executor::Post(std::function<void()> task) {
  {
    MutexLock lock(&mutex_);
    tasks_.push_back(std::move(task));
  }
  wake_.Signal();
}

absl::Status Executor::WaitUntilIdle() {
  MutexLock lock(&mutex_);
  while (!tasks_.empty() || running_ > 0) idle_.Wait(&mutex_);
  return std::exchange(thrown_, absl::OkStatus());
}

void Executor::Work() {
  while (true) {
    std::function<void()> task;
    {
      MutexLock lock(&mutex_);
      while (!stopping_ && tasks_.empty()) wake_.Wait(&mutex_);
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
      ++running_;
    }
    absl::Status thrown;
    try {
      task();
    } catch (...) {
      thrown = CaughtStatus();
    }
    task = nullptr;  // Destroy captures outside the lock.
    MutexLock lock(&mutex_);
    thrown_.Update(std::move(thrown));
    --running_;
    if (tasks_.empty() && running_ == 0) idle_.SignalAll();
  }
}

}  // namespace isthmus
