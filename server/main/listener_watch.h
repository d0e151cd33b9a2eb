// A watch on the server's own listener, for a service manager that restarts a stuck server.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <functional>
#include <string>

namespace isthmus::server {

// OK if a program accepts a new connection at the address, as RpcServer::address() names it, with
// TLS or without: it answers the beginning of HTTP/2 or hangs up, which the system alone does
// neither of. FailedPrecondition where this machine does not have the address now, as without its
// Wi-Fi: nothing is known then. DeadlineExceeded where nobody accepts in time, else the error of
// connecting.
absl::Status ProbeListener(const std::string& address, std::chrono::milliseconds patience);

// Not thread safe.
class ListenerWatch {
 public:
  struct Options {
    std::function<absl::Status()> probe;
    // Called for each probe that did not fail. FailedPrecondition is no failure: a restart would
    // not bring the address back.
    std::function<void()> on_answer;
    std::function<void(const absl::Status&)> on_silence;  // For the first of several in a row.
  };

  explicit ListenerWatch(Options options) : options_(std::move(options)) {}

  void Probe();

 private:
  const Options options_;
  bool is_silent_ = false;
};

}  // namespace isthmus::server
