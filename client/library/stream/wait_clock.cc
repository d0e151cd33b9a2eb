#include "client/library/stream/wait_clock.h"

#include <algorithm>
#include <chrono>

namespace isthmus::client {
namespace {

class SystemWaitClock final : public WaitClock {
 public:
  double Now() const override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }

  bool WaitUntil(CondVar* changed, Mutex* mutex, double deadline,
                 const std::function<bool()>& ready) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) override {
    // At most a day at a time: an infinite deadline would overflow the clock's ticks.
    while (!ready()) {
      const double seconds = std::min(deadline - Now(), 86'400.0);
      if (seconds <= 0) return false;
      changed->WaitFor(mutex, std::chrono::duration<double>(seconds));
    }
    return true;
  }
};

}  // namespace

const WaitClock& WaitClock::System() {
  static const SystemWaitClock clock;
  return clock;
}

}  // namespace isthmus::client
