#include "lab/loadgen/connection_churn.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>

#include "lab/loadgen/dial.h"

namespace isthmus::loadgen {

ConnectionChurn::ConnectionChurn(const std::string& server, double per_s) {
  if (per_s > 0) thread_ = std::thread([this, server, per_s] { Run(server, per_s); });
}

ConnectionChurn::~ConnectionChurn() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void ConnectionChurn::Run(const std::string& server, double per_s) {
  using Seconds = std::chrono::duration<double>;
  const auto start = std::chrono::steady_clock::now();
  for (int64_t i = 0; !stopping_; ++i) {
    std::this_thread::sleep_until(start + Seconds(static_cast<double>(i) / per_s));
    const int socket = Dial(server);
    if (socket < 0) {
      ++refused_;
      continue;
    }
    // With a reset: ports that wait for stragglers would be used up after half a minute.
    HangUp(socket);
    ++made_;
  }
}

}  // namespace isthmus::loadgen
