// Peers that hold what a server has without using it, or do not speak as agreed.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace isthmus::loadgen {

struct MisbehavingClientOptions {
  int half_open = 0;           // Connections in which nothing is ever said.
  int slow_writers = 0;        // Connections with a request that comes byte by byte.
  int slow_readers = 0;        // Queries of everything, of which a piece is read every second.
  double malformed_per_s = 0;  // Streams of scans whose first message is noise.

  bool any() const { return half_open + slow_writers + slow_readers > 0 || malformed_per_s > 0; }
};

struct MisbehavingClientResult {
  int64_t closed = 0;      // Connections of the first two kinds that the server ended.
  int64_t not_made = 0;    // Connections that the server did not take.
  int64_t pieces = 0;      // Read by slow readers.
  int64_t cut_off = 0;     // Their queries that the server ended before they had read all.
  int64_t malformed = 0;   // Streams that were answered with an error, as they should be.
  int64_t tolerated = 0;   // Streams that ended with OK.
  int64_t unanswered = 0;  // Streams without an answer in time.
};

// Connections and streams that the server ends are begun anew a second later. A thread for
// connections, one for malformed streams, one for each slow reader. Thread safe.
class MisbehavingClients {
 public:
  MisbehavingClients(const std::string& server, const MisbehavingClientOptions& options,
                     uint64_t seed);
  ~MisbehavingClients();

  MisbehavingClientResult Result() const;

 private:
  void HoldConnections(const std::string& server, const MisbehavingClientOptions& options);
  void SendNoise(const std::string& server, double per_s, uint64_t seed);
  void ReadSlowly(const std::string& server);

  std::atomic<bool> stopping_ = false;
  std::atomic<int64_t> closed_ = 0, not_made_ = 0, pieces_ = 0, cut_off_ = 0;
  std::atomic<int64_t> malformed_ = 0, tolerated_ = 0, unanswered_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace isthmus::loadgen
