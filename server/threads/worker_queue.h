// The queue of workers as matching's thread sees it: jobs given away, and what comes of them.
#pragma once

#include <absl/status/status.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "core/stopwatch.h"
#include "server/jobs/job.h"
#include "server/map/map_view.h"
#include "server/threads/crash_journal.h"
#include "server/threads/matching_ledger.h"
#include "storage/job_queue.h"

namespace isthmus::server {

// Keeps in the ledger which jobs are posted, and makes due again those that workers do not do. For
// the thread that has the ledger, but for counts().
class WorkerQueue {
 public:
  struct Hooks {
    // Takes the result of an ended job, which stays in the queue where that is Unavailable or
    // ResourceExhausted.
    std::function<absl::Status(const MapView& view, const JobKey& key, const JobResult& result)>
        take;
    // Told of a posted job that has come to nothing.
    std::function<void(const JobKey& key)> on_failed;
    // Told that a job is due again without a change of the map.
    std::function<void()> on_due;
    // Told of trouble with the queue, once; others tell of trouble with the way to it.
    std::function<void(const std::string& problem)> on_problem;
  };
  // As of the last look; for any thread.
  struct Counts {
    std::atomic<uint64_t> workers = 0, posted = 0, set_aside = 0;
  };

  // `queue` is null where there are no workers.
  WorkerQueue(storage::JobQueue* queue, MatchingLedger* ledger, WorkGuard* guard, Hooks hooks);

  // Goes on with jobs that an earlier server of the site has left in the queue.
  void Adopt(const MapView& view);
  // Looks, now and then, whether there are workers and what they have done.
  void Follow(const MapView& view);
  void Post(const JobKey& key, const Job& job);
  // Workers end with it: it is left out until its row is taken off the queue.
  bool IsSetAside(const JobKey& key) const { return set_aside_.contains(key); }

  bool is_there() const { return queue_ != nullptr; }
  bool has_workers() const { return has_workers_; }
  // The server's own search for loops, with so many submaps waiting, falls behind, and workers come
  // to it.
  bool WantsLoops(uint64_t waiting_submaps) const;
  const Counts& counts() const { return counts_; }

 private:
  void TellOfTrouble(const std::string& what, const absl::Status& status);
  void SetAside(const JobKey& key, const std::string& problem);
  void TakeResults(const MapView& view);
  absl::Status TakeEnded(const MapView& view, const JobKey& key, const storage::EndedJob& job);
  // `status` is what became of taking it.
  void Finish(const JobKey& key, const storage::EndedJob& job, const absl::Status& status);
  void CountWorkers();
  // Jobs that somebody has taken off the queue, or that went with the database's last moments.
  void ForgetMissing();
  // Searches for loops that workers, at pairs meanwhile, do not come to.
  void TakeBackLoops();
  // Jobs of deleted sessions.
  void RemoveGone(const MapView& view);
  // There is nobody to do them.
  void WithdrawJobs();

  storage::JobQueue* const queue_;
  MatchingLedger* const ledger_;
  WorkGuard* const guard_;
  const Hooks hooks_;
  Counts counts_;
  std::set<std::string> told_;
  std::set<JobKey> set_aside_;  // In the queue too.
  bool has_workers_ = false, told_of_other_versions_ = false;
  std::optional<Stopwatch> looked_for_workers_, looked_for_results_, took_loops_back_;
};

}  // namespace isthmus::server
