// A bad link: a TCP proxy that resets, stalls, chokes, forgets and goes away when told to.
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <random>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"

namespace isthmus::faults {

// Carries connections from a port of its own to a server's socket. Thread safe.
class Proxy {
 public:
  // `backend` is the path of a Unix socket; it need not be there yet. Throws without a port.
  Proxy(const std::string& backend, uint64_t seed);
  ~Proxy();
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  std::string address() const;  // For clients; "127.0.0.1:port".

  // Each way, all connections together; 0: no limit.
  void SetRate(double bytes_per_s);
  // While true nothing moves, and nobody is told: sent bytes wait.
  void Stall(bool is_stalled);
  // While true there is no link: open connections were reset, new ones are reset.
  void Cut(bool is_cut);
  // Resets each open connection with that probability; returns their number.
  int Reset(double probability);
  // Half-open: the server's end of all that is open goes away, and the client is not told, now or
  // later. New connections work.
  void Forget();

  int64_t resets() const { return resets_; }
  int64_t bytes() const { return bytes_; }  // Carried, both ways.

 private:
  struct Direction {
    int from = -1, to = -1;
    std::string waiting = {};
    bool has_ended = false;
  };
  struct Pair {
    Direction up, down;  // From the client; to it.
    bool is_forgotten = false;
  };

  void Run();
  void Accept() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Open(int client) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // False once the connection is over.
  bool Carry(Direction& direction, double& allowance) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Close(Pair& pair, bool reset) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Refill() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string backend_;
  int port_ = 0;  // Before listener_, which finds it.
  int listener_ = -1;
  std::atomic<bool> stopping_ = false;
  std::atomic<int64_t> resets_ = 0, bytes_ = 0;

  mutable Mutex mutex_;
  std::mt19937_64 random_ ABSL_GUARDED_BY(mutex_);
  std::list<Pair> pairs_ ABSL_GUARDED_BY(mutex_);
  double rate_ ABSL_GUARDED_BY(mutex_) = 0;                                   // Bytes a second.
  double up_ ABSL_GUARDED_BY(mutex_) = 0, down_ ABSL_GUARDED_BY(mutex_) = 0;  // Bytes allowed now.
  double last_s_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_stalled_ ABSL_GUARDED_BY(mutex_) = false, is_cut_ ABSL_GUARDED_BY(mutex_) = false;

  std::thread thread_;
};

}  // namespace isthmus::faults
