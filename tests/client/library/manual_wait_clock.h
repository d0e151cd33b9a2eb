// A clock for the client library that stands still until told otherwise.
#pragma once

#include <atomic>
#include <chrono>

#include "client/library/stream/wait_clock.h"

namespace isthmus::client {

class ManualWaitClock final : public WaitClock {
 public:
  void Advance(double seconds) { now_ = now_ + seconds; }

  double Now() const override { return now_; }
  bool WaitUntil(CondVar* changed, Mutex* mutex, double deadline,
                 const std::function<bool()>& ready) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) override {
    // Looks every now and then whether it was told.
    while (!ready() && Now() < deadline) changed->WaitFor(mutex, std::chrono::milliseconds(1));
    return ready();
  }

 private:
  std::atomic<double> now_{1000};
};

}  // namespace isthmus::client
