#include "server/rpc/streams/watchdog.h"

#include <utility>
#include <vector>

#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

void Watchdog::Timer::Arm(std::chrono::milliseconds after) {
  MutexLock lock(&watchdog_.mutex_);
  due_ = watchdog_.now_() + after;
  if (watchdog_.armed_.empty()) watchdog_.changed_.SignalAll();
  watchdog_.armed_.insert(this);
}

void Watchdog::Timer::Disarm() {
  MutexLock lock(&watchdog_.mutex_);
  due_.reset();
  watchdog_.armed_.erase(this);
}

Watchdog::Watchdog(std::function<Time()> now)
    : now_(now ? now : [] { return std::chrono::steady_clock::now(); }) {
  if (!now) thread_ = std::thread([this] { WatchUntilStopped(); });
}

Watchdog::~Watchdog() {
  {
    MutexLock lock(&mutex_);
    stopped_ = true;
    changed_.SignalAll();
  }
  if (thread_.joinable()) thread_.join();
}

void Watchdog::Check() {
  MutexLock lock(&mutex_);
  FireDue();
}

void Watchdog::FireDue() {
  const Time now = now_();
  std::vector<Timer*> due;
  for (Timer* timer : armed_) {
    if (*timer->due_ <= now) due.push_back(timer);
  }
  for (Timer* timer : due) {
    armed_.erase(timer);
    timer->due_.reset();
    timer->fire_();
  }
}

void Watchdog::WatchUntilStopped() {
  MutexLock lock(&mutex_);
  while (!stopped_) {
    if (armed_.empty()) {
      changed_.Wait(&mutex_);
      continue;
    }
    FireDue();
    changed_.WaitFor(&mutex_, kTick);
  }
}

}  // namespace isthmus::rpc
