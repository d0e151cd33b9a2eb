// Connections that come and go at once, as of a port scanner, a probe or a radio at its edge.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

namespace isthmus::loadgen {

// One thread. Thread safe.
class ConnectionChurn {
 public:
  // So many a second to "host:port", evenly; 0: none.
  ConnectionChurn(const std::string& server, double per_s);
  ~ConnectionChurn();

  int64_t made() const { return made_; }
  int64_t refused() const { return refused_; }

 private:
  void Run(const std::string& server, double per_s);

  std::atomic<bool> stopping_ = false;
  std::atomic<int64_t> made_ = 0, refused_ = 0;
  std::thread thread_;
};

}  // namespace isthmus::loadgen
