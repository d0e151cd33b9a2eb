#include "server/main/periodic.h"

#include <absl/time/clock.h>

#include <utility>

#include "core/concurrency/thread_role.h"

namespace isthmus::server {

Periodic::Periodic(const std::string& name, std::chrono::milliseconds period,
                   std::function<void()> work)
    : period_(period), thread_([this, name, run = std::move(work)] {
        NameThread(name);
        do {
          run();
        } while (WaitForNext());
      }) {}

Periodic::~Periodic() {
  {
    MutexLock lock(&mutex_);
    is_stopped_ = true;
    changed_.SignalAll();
  }
  thread_.join();
}

bool Periodic::WaitForNext() {
  const auto next = absl::Now() + absl::FromChrono(period_);
  MutexLock lock(&mutex_);
  while (!is_stopped_) {
    if (changed_.WaitWithDeadline(&mutex_, next)) break;
  }
  return !is_stopped_;
}

}  // namespace isthmus::server
