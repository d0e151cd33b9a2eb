// Time as far as the library waits for it, so that tests need not.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>

namespace isthmus::client {

// Thread safe.
class WaitClock {
 public:
  virtual ~WaitClock() = default;
  // Seconds since some instant; never goes back.
  virtual double Now() const = 0;
  // Waits on `changed` until `ready` holds or it is `deadline`; returns what `ready` says then.
  virtual bool WaitUntil(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                         double deadline, const std::function<bool()>& ready) const = 0;

  // The machine's steady clock; lives for ever.
  static const WaitClock& System();
};

}  // namespace isthmus::client
