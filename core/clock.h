// Time as a dependency, so that what waits or stamps can be tested without waiting.
#pragma once

#include <atomic>
#include <cstdint>

namespace isthmus {

// Thread safe.
class Clock {
 public:
  virtual ~Clock() = default;
  // Nanoseconds since the Unix epoch.
  virtual int64_t NowNs() const = 0;

  // The machine's clock; lives for ever.
  static const Clock& System();
};

// Stands still until told otherwise. Thread safe.
class ManualClock : public Clock {
 public:
  explicit ManualClock(int64_t now_ns = 0) : now_ns_(now_ns) {}
  int64_t NowNs() const override { return now_ns_.load(); }
  void Advance(int64_t ns) { now_ns_ += ns; }

 private:
  std::atomic<int64_t> now_ns_;
};

}  // namespace isthmus
