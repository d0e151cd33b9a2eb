// The looking after a server that serves for months: its service manager told, its listener and
// its certificates watched.
#pragma once

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
  // Tells the service manager that the server is ready at `address`, and then, where it asks for
  // that, that it is alive as long as its listener answers. `on_certificate` is told of
  // certificates that expire or cannot be read, as the log is.
  Supervision(const ServerConfig& config, const std::string& address,
              std::function<void(const std::string& trouble)> on_certificate);
  // Tells it that the server ends, and watches no longer.
  void Stop();

 private:
  void WatchListener(const std::string& address);

  const ServiceManager manager_;
  std::unique_ptr<Periodic> listener_, certificates_;
};

}  // namespace isthmus::server
