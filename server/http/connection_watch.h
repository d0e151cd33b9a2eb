// The time that each connection may take for its present phase.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <set>

#include "core/concurrency/mutex.h"

namespace isthmus::http {

// One connection. Thread safe.
class Connection {
 public:
  Connection(int file, const void* owner) : file_(file), owner_(owner) { BeginReceiving(); }

  void BeginReceiving() { Begin(Phase::kReceiving); }
  void BeginWorking() { Begin(Phase::kWorking); }  // The client has no time limit then.
  void BeginSending() { Begin(Phase::kSending); }

  // True if the client has closed it, or it was cut.
  bool IsGone() const;

 private:
  friend class ConnectionWatch;
  enum class Phase { kReceiving, kWorking, kSending };
  void Begin(Phase phase);

  const int file_;
  const void* const owner_;
  std::atomic<Phase> phase_ = Phase::kReceiving;
  std::atomic<int64_t> since_ns_ = 0;  // By the steady clock.
};

// Thread safe.
class ConnectionWatch {
 public:
  ConnectionWatch(std::chrono::milliseconds request_time, std::chrono::milliseconds piece_time)
      : request_time_(request_time), piece_time_(piece_time) {}

  // The file must be open until Remove returns. `owner` only tells whose it is.
  Connection* Add(int file, const void* owner);
  void Remove(Connection* watched);
  // Cuts connections whose time is up; their readers and writers find them closed.
  void CutSlow();
  // Cuts all of that owner, and waits until they are removed; so long at most.
  void CutAll(const void* owner, std::chrono::milliseconds patience);

 private:
  // Returns the number of connections that it cut.
  int CutOf(const void* owner) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::chrono::milliseconds request_time_, piece_time_;
  Mutex mutex_;
  CondVar removed_;
  std::set<std::unique_ptr<Connection>> connections_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::http
