// Time as far as the library waits for it, so that tests need not.
#pragma once

#include <functional>

#include "core/concurrency/mutex.h"

namespace isthmus::client {

// Thread safe.
class WaitClock {
 public:
  virtual ~WaitClock() = default;
  // Seconds since some instant; never goes back.
  virtual double Now() const = 0;
  // Waits on `changed` until `ready` holds or it is `deadline`; returns what `ready` says then. It
  // is called with `mutex` held.
  virtual bool WaitUntil(CondVar* changed, Mutex* mutex, double deadline,
                         const std::function<bool()>& ready) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) = 0;

  // The machine's steady clock; lives for ever.
  static const WaitClock& System();
};

}  // namespace isthmus::client
