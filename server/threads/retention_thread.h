// The thread that keeps count of what the robots have stored and holds them to their limits.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "server/ingest/retention.h"
#include "server/retention_options.h"

namespace isthmus::server {

// Thread safe.
class RetentionThread {
 public:
  // Callbacks into its surroundings; called from the thread, without its locks held.
  struct Hooks {
    // All sessions, without their bytes.
    std::function<std::vector<ingest::StoredSession>()> list;
    std::function<absl::StatusOr<uint64_t>(const SessionId&)> map_bytes;
    std::function<uint64_t(const SessionId&)> scan_bytes;
    std::function<absl::Status(const ingest::RetentionAction&)> act;
    std::function<void(const std::string&)> on_problem;  // May be null.
  };

  RetentionThread(const RetentionOptions& options, const Clock* clock, Hooks hooks);
  ~RetentionThread();  // Stop(), and waits.

  // Counts everything and does what is due; then starts the thread. Call once.
  void Start();
  void Stop();
  // The session's stored data has changed, or it has come, finished or gone.
  void NoteChange(const SessionId& session);
  // Until every change so far has been looked at.
  void WaitUntilIdle();

  // ResourceExhausted, saying what to do, while the robot may add nothing.
  absl::Status CheckQuota(const RobotId& robot) const;
  // As counted last; 0 for one that is not known.
  uint64_t MapBytes(const SessionId& session) const;

 private:
  void Run();
  void RunRound();
  void CountAndDo();
  // All sessions with their bytes.
  std::vector<ingest::StoredSession> CountStored();
  // Returns whether anything went.
  bool CarryOut(const ingest::RetentionPlan& plan);

  const RetentionOptions options_;
  const Clock* const clock_;
  const Hooks hooks_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::map<SessionId, uint64_t> map_bytes_ ABSL_GUARDED_BY(mutex_);
  std::set<SessionId> stale_ ABSL_GUARDED_BY(mutex_);  // To be counted anew.
  std::map<RobotId, std::string> refused_ ABSL_GUARDED_BY(mutex_);
  std::string all_refused_ ABSL_GUARDED_BY(mutex_);
  uint64_t changes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t looked_at_ ABSL_GUARDED_BY(mutex_) = 0;  // Changes that were looked at.
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::server
