// Ctrl-C, and what ends a program otherwise, as an event.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace isthmus::cli {

// While it lives, the first SIGINT or SIGTERM calls `on_interrupt`, from a thread of its own; the
// second, unless it comes in the same instant, ends the process at once, with kInterrupted. Make it
// before threads are started, which would get the signals otherwise. One at a time.
class Interruption {
 public:
  explicit Interruption(std::function<void()> on_interrupt);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool happened() const { return happened_; }

 private:
  void Watch();

  const std::function<void()> on_interrupt_;
  std::atomic<bool> happened_{false}, ending_{false};
  std::thread thread_;  // Last: it uses all else.
};

}  // namespace isthmus::cli
