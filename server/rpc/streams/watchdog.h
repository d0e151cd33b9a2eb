// Timers of calls, looked at by one thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "core/concurrency/mutex.h"

namespace isthmus::rpc {

// Thread safe. Timers fire up to kTick late. The thread sleeps while none is armed.
class Watchdog {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // A timer that is armed and disarmed by whoever it watches. Thread safe.
  class Timer {
   public:
    // `fire` is called by the watchdog's thread, once for each time that it was armed. It must not
    // wait, nor touch a timer.
    Timer(Watchdog* watchdog, std::function<void()> fire)
        : watchdog_(*watchdog), fire_(std::move(fire)) {}
    ~Timer() { Disarm(); }
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;

    // From now on; in place of what was armed before.
    void Arm(std::chrono::milliseconds after);
    // It does not fire any more once this has returned.
    void Disarm();

   private:
    friend class Watchdog;
    Watchdog& watchdog_;
    const std::function<void()> fire_;
    std::optional<Time> due_;  // Guarded by the watchdog's mutex.
  };

  // `now` is for tests, which call Check themselves; null: the steady clock, and a thread.
  explicit Watchdog(std::function<Time()> now = nullptr);
  ~Watchdog();

  // Fires what is due.
  void Check();

 private:
  void WatchUntilStopped();
  void FireDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::function<Time()> now_;
  Mutex mutex_;
  CondVar changed_;
  std::set<Timer*> armed_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::rpc
