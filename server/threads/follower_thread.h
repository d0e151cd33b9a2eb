// The thread of a server that only reads a map: it looks in the store for what is new, and shows
// it.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/records/replica_state.h"
#include "server/map/event_journal.h"
#include "server/map/map_writer.h"
#include "storage/map_follower.h"

namespace isthmus::server {

// Thread safe.
class FollowerThread {
 public:
  // Told, from the thread, once when the store cannot be followed any more, and once when it can.
  using OnProblem = std::function<void(const std::string& problem)>;

  // `events`: whoever waits for new ones is woken.
  FollowerThread(std::unique_ptr<storage::MapFollower> follower, MapWriter* map,
                 EventJournal* events, const Clock* clock, OnProblem on_problem);
  ~FollowerThread();  // Stop(), and waits.

  // Shows all of the map; then starts the thread. Call once. Errors are the follower's.
  absl::Status Start();
  void Stop();
  // Until it has looked at what the store held when this was called, or failed to.
  void WaitUntilLooked();

  ReplicaState state() const;

 private:
  void Run();
  absl::Status Look();
  void Note(const absl::Status& status);

  const std::unique_ptr<storage::MapFollower> follower_;  // The thread's, once there is one.
  MapWriter* const map_;
  EventJournal* const events_;
  const Clock* const clock_;
  const OnProblem on_problem_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::string owner_ ABSL_GUARDED_BY(mutex_);
  std::string problem_ ABSL_GUARDED_BY(mutex_);
  int64_t seen_ns_ ABSL_GUARDED_BY(mutex_) = 0;  // When all was read last.
  uint64_t wanted_ ABSL_GUARDED_BY(mutex_) = 0;  // Looks that somebody waits for, counted, ...
  uint64_t looked_ ABSL_GUARDED_BY(mutex_) = 0;  // ... and that are done.
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::server
