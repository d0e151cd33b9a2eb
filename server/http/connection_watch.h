// The time that each connection may take for what it is at.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <set>

#include "core/concurrency/mutex.h"

namespace isthmus::http {

// One connection. Thread safe.
class Link {
 public:
  Link(int file, const void* owner) : file_(file), owner_(owner) { BeginReceiving(); }

  void BeginReceiving() { Begin(Phase::kReceiving); }
  void BeginWorking() { Begin(Phase::kWorking); }  // For which nothing is asked of the client.
  void BeginSending() { Begin(Phase::kSending); }

  // Whether its client has closed it, or it was cut.
  bool IsGone() const;

 private:
  friend class ConnectionWatch;
  enum class Phase { kReceiving, kWorking, kSending };
  void Begin(Phase phase);

  const int file_;
  const void* const owner_;
  std::atomic<Phase> phase_ = Phase::kReceiving;
  std::atomic<int64_t> since_ns_ = 0;  // Of the steady clock.
};

// Thread safe.
class ConnectionWatch {
 public:
  ConnectionWatch(std::chrono::milliseconds request_time, std::chrono::milliseconds piece_time)
      : request_time_(request_time), piece_time_(piece_time) {}

  // The file must be open until Remove returns. `owner` only tells whose it is.
  Link* Add(int file, const void* owner);
  void Remove(Link* link);
  // Cuts those whose time is up; whoever reads from or writes to them finds them closed.
  void CutSlow();
  // Cuts all of that owner, and waits until they are removed; so long at most.
  void CutAll(const void* owner, std::chrono::milliseconds patience);

 private:
  // How many there were.
  int CutOf(const void* owner) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::chrono::milliseconds request_time_, piece_time_;
  Mutex mutex_;
  CondVar removed_;
  std::set<std::unique_ptr<Link>> links_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::http
