// SIGTERM and SIGINT as something to wait for.
#pragma once

#include <signal.h>

#include <string>

namespace isthmus::server {

// Make it before the first thread: threads inherit that the signals are blocked. Not thread safe.
class StopSignal {
 public:
  // Also ignores SIGPIPE: a reader of stdout that went away must not end the server.
  StopSignal();

  // Returns the name of the first signal. The next one ends the process at once.
  std::string Wait();

 private:
  sigset_t signals_;
};

}  // namespace isthmus::server
