// A bad link: a TCP proxy that resets, stalls, chokes, forgets and goes away when told to.
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <mutex>
#include <random>
#include <string>
#include <thread>

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
  // While true nothing moves, and nobody is told: what is sent waits.
  void Stall(bool is_stalled);
  // While true there is no link: what is open was reset, what comes is reset.
  void Cut(bool is_cut);
  // Resets each open connection with that probability; how many.
  int Reset(double probability);
  // Half-open: the server's end of all that is open goes away, and the client is not told, now or
  // later. New connections work.
  void Forget();

  int64_t resets() const { return resets_; }
  int64_t bytes() const { return bytes_; }  // Carried, both ways.

 private:
  struct Way {
    int from = -1, to = -1;
    std::string waiting = {};
    bool has_ended = false;
  };
  struct Pair {
    Way up, down;  // From the client; to it.
    bool is_forgotten = false;
  };

  void Run();
  // mutex_ is held for these.
  void Accept();
  void Open(int client);
  bool Carry(Way& way, double& allowance);  // False once the connection is over.
  void Close(Pair& pair, bool reset);
  void Refill();

  const std::string backend_;
  int port_ = 0;  // Before listener_, which finds it.
  int listener_ = -1;
  std::atomic<bool> stopping_ = false;
  std::atomic<int64_t> resets_ = 0, bytes_ = 0;

  mutable std::mutex mutex_;  // Guards all below.
  std::mt19937_64 random_;
  std::list<Pair> pairs_;
  double rate_ = 0, up_ = 0, down_ = 0;  // Bytes a second; that may pass now.
  double last_s_ = 0;
  bool is_stalled_ = false, is_cut_ = false;

  std::thread thread_;
};

}  // namespace isthmus::faults
