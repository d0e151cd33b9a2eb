// A TCP relay between one robot and the server that has the faults of a radio link.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include "lab/loadgen/link_profile.h"

namespace isthmus::loadgen {

// One thread, which owns all connections. Thread safe.
class Relay {
 public:
  // Listens on a port of this machine for one robot. `server` is "host:port" or "unix:PATH"; it
  // need not be there yet. InvalidArgument where the address is none, ResourceExhausted without a
  // free port.
  static absl::StatusOr<std::unique_ptr<Relay>> Open(const std::string& server,
                                                     const LinkProfile& profile, uint64_t seed);
  ~Relay();

  std::string address() const;              // "127.0.0.1:port".
  int64_t bytes_up() const { return up_; }  // Carried towards the server.
  int64_t bytes_down() const { return down_; }
  int resets() const { return resets_; }

 private:
  struct Piece {
    double due_s;
    std::string bytes;
  };
  struct Direction {
    int from = -1, to = -1;
    double bytes_s = 0;
    std::atomic<int64_t>* carried = nullptr;
    std::deque<Piece> waiting = {};
    size_t waiting_bytes = 0;
    double free_s = 0;  // When the last piece has left the sender.
    double last_s = 0;  // When the last piece arrives.
    bool has_ended = false;
  };
  struct Pair {
    Direction up, down;
  };

  Relay(std::string server, const LinkProfile& profile, uint64_t seed);
  absl::Status Listen();
  void Run();
  void Accept();
  bool Carry(Direction& direction, double now_s);  // False once the connection is over.
  bool Read(Direction& direction, double now_s);
  bool Write(Direction& direction, double now_s);
  void PlanFaults(double now_s);
  double Draw(double mean);  // Exponential; far away where the mean is 0.
  static void Close(Pair& pair);

  const std::string server_;
  const LinkProfile profile_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<bool> stopping_ = false;
  std::atomic<int64_t> up_ = 0, down_ = 0;
  std::atomic<int> resets_ = 0;

  // The thread's own.
  std::mt19937_64 random_;
  std::list<Pair> pairs_;
  double stall_at_s_ = 0, stalled_until_s_ = 0, reset_at_s_ = 0;

  std::thread thread_;
};

}  // namespace isthmus::loadgen
