// A thread that does the same every so often, from its making to its end.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"

namespace isthmus::server {

class Periodic {
 public:
  // `work` runs at once, then after each `period`, on a thread of that name; it must not throw.
  Periodic(const std::string& name, std::chrono::milliseconds period, std::function<void()> work);
  // Waits for what is at work.
  ~Periodic();
  Periodic(const Periodic&) = delete;
  Periodic& operator=(const Periodic&) = delete;

 private:
  // False once it is to end.
  bool WaitForNext();

  const std::chrono::milliseconds period_;
  Mutex mutex_;
  CondVar changed_;
  bool is_stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::server
