// SIGTERM and SIGINT as something to wait for; SIGHUP as nothing that ends a server.
#pragma once

#include <signal.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace isthmus::server {

// Make it in the first line of `main`: from then on no signal ends the program in the middle of
// anything, and threads inherit that the signals are blocked. Not thread safe.
class StopSignal {
 public:
  // Also ignores SIGPIPE: a reader of stdout that went away must not end the server.
  StopSignal();

  // Lets the signals end the program again: for work that may stop at any moment.
  void Unblock();

  // Returns the name of the first signal that ends the server. The next one ends the process at
  // once. SIGHUP, which a terminal that is closed sends and habit takes for "read the configuration
  // again", calls `on_hangup` and ends nothing, then and later.
  std::string Wait(const std::function<void()>& on_hangup);
  // Waits at most so long; nothing if no signal came. The next one is like the first.
  std::optional<std::string> WaitFor(std::chrono::milliseconds longest,
                                     const std::function<void()>& on_hangup);

 private:
  sigset_t signals_;
};

}  // namespace isthmus::server
