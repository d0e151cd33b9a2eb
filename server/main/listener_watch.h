// A watch on the server's own listener: gRPC stops accepting connections for good when the process
// has had no file left for one, and nothing but a restart mends that.
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
    // So many failed probes in a row make a listener deaf. 0: nothing does. One that ends with
    // FailedPrecondition is none of them: a restart would not bring the address back.
    int max_failures = 0;
    std::function<absl::Status()> probe;
    std::function<void()> on_answer;                      // Of each probe that did not fail.
    std::function<void(const absl::Status&)> on_silence;  // Once, for the first without.
    std::function<void()> on_deaf;                        // Once.
  };

  explicit ListenerWatch(Options options) : options_(std::move(options)) {}

  void Probe();

 private:
  const Options options_;
  int failures_ = 0;  // In a row.
};

}  // namespace isthmus::server
