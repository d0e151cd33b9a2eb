// The program that started the server and looks after it, as systemd does: told what the server is
// doing, in the protocol of sd_notify(3).
#pragma once

#include <chrono>
#include <string>

namespace isthmus::server {

// Thread safe.
class ServiceManager {
 public:
  // The one that NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID of the environment name, if any.
  static ServiceManager FromEnvironment();

  // Lines of NAME=VALUE. Without effect where nobody asked or nobody listens.
  void Tell(const std::string& state) const;
  // The longest time between two WATCHDOG=1 that it wants; zero: it wants none.
  std::chrono::milliseconds watchdog() const { return watchdog_; }

 private:
  std::string socket_;
  std::chrono::milliseconds watchdog_{0};
};

}  // namespace isthmus::server
