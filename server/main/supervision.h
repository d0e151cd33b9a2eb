// The looking after a server that serves for months: its service manager told, its listener and
// its certificates watched.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "server/main/config.h"
#include "server/main/periodic.h"
#include "server/main/service_manager.h"

namespace isthmus::server {

// Thread safe.
class Supervision {
 public:
  // Tells the service manager that the server is ready at `address`. A listener that stays deaf
  // sends this process a SIGTERM.
  // `on_certificate` is told of certificates that expire or cannot be read, as the log is.
  Supervision(const ServerConfig& config, const std::string& address,
              std::function<void(const std::string& trouble)> on_certificate);
  // Tells it that the server ends, and watches no longer.
  void Stop();
  // Whether that was why.
  bool was_deaf() const { return was_deaf_; }

 private:
  void WatchListener(int limit_s, const std::string& address);

  const ServiceManager manager_;
  std::atomic<bool> was_deaf_ = false;
  std::unique_ptr<Periodic> listener_, certificates_;
};

}  // namespace isthmus::server
