// The slow loop: a thread that finds where sessions came back to, how two sessions' maps lie to
// each other, and which submaps have been seen again often enough. Nobody waits for it. Where
// there are workers these match, compare and, where it falls behind, search, by the queue of the
// store.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stop_token>
#include <string>
#include <thread>

#include "core/clock.h"
#include "core/records/server_load.h"
#include "core/stopwatch.h"
#include "server/jobs/await_store.h"
#include "server/jobs/job_key.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/limits.h"
#include "server/jobs/prepared_store.h"
#include "server/map/map_writer.h"
#include "server/matching/index/place_index.h"
#include "server/matching/loops/revisits.h"
#include "server/matching/pairs/matcher.h"
#include "server/threads/crash_journal.h"
#include "server/threads/matching_ledger.h"
#include "server/threads/matching_schedule.h"
#include "server/threads/session_shapes.h"
#include "server/threads/stored_progress.h"
#include "server/threads/worker_queue.h"

namespace isthmus::server {

class MatchingThread {
 public:
  struct Options {
    matching::MatcherOptions matcher;
    matching::LoopOptions loops;
    matching::RevisitOptions revisits;
    int rematch_submaps = 1;  // See ScheduleOptions.
    // The memory that maps kept ready may take, without the two at hand.
    size_t prepared_bytes = size_t{128} << 20;
    // See CrashJournal; empty: none.
    std::string crash_journal;
    // Told, from the thread, what was left out and why. May be null.
    std::function<void(const std::string& problem)> on_problem;
  };

  MatchingThread(MapWriter* map, Activity* activity, storage::MapStore* store, SubmapCache* submaps,
                 const Clock* clock, const Options& options);
  ~MatchingThread();  // Stops.

  // True if the view shows nothing that it has not dealt with.
  bool IsUpToDateWith(const MapView& view) const { return up_to_date_with_ == view.serial; }

  MatchingLoad Load(const MapView& view) const {
    const WorkerQueue::Counts& counts = queue_.counts();
    return {IsUpToDateWith(view), waiting_submaps_, waiting_pairs_,
            counts.workers,       counts.posted,    counts.set_aside + guard_.left_out()};
  }
  uint64_t prepared_bytes() const { return prepared_bytes_; }  // Maps kept ready.

  // Makes the thread end within a second or so; does not wait. What is under way is given up, to be
  // taken up at the next start.
  void Stop();

 private:
  void Run();
  // Does the job that comes first; false when all is up to date.
  bool RunNext(const MapView& view);

  // Null where it cannot be read. As the next one throws Stopped.
  std::shared_ptr<const Submap> OutlineOf(const SubmapId& submap) const;
  // Null without an outline, and without a surface if the submap cannot be read.
  std::shared_ptr<const matching::PreparedSubmap> GetPrepared(const SubmapId& submap) const;
  // As WaitForStore: nothing is matched with a part of a map.
  bool WaitForStoreSince(const Stopwatch& since) const;
  // Throws what `write` fails with; only once the store is back, and has room again.
  void AwaitStored(const std::function<absl::Status()>& write) const;

  void FindLoops(const MapView& view, const SubmapId& submap);
  // The job has the session's submaps up to this one.
  LoopJob MakeLoopJob(const MapView& view, const SubmapId& submap, const SessionView& session,
                      const Placement& placement) const;

  void IndexSession(const MapView& view, const SessionId& id);
  void EstimateMatch(const MapView& view, const SessionPair& pair);
  // The job without its maps and anchors. `older` is null where nothing is known of the pair.
  PairJob MakePairJob(const SessionPair& pair, const MatchTrigger& trigger,
                      const Match* older) const;

  // Gives the job to workers, or does it here and takes its result.
  void Do(const MapView& view, const JobKey& key, const Job& job, bool by_workers);
  // Waits while the store is away. Throws Stopped, or StatusError if nothing comes of it.
  JobResult RunHere(const Job& job);
  // Takes the result of workers, maybe of a match that an earlier server has posted.
  absl::Status TakeEnded(const MapView& view, const JobKey& key, const JobResult& result);
  // Into the map, the index, and what is remembered for the next job.
  absl::Status Take(const MapView& view, const JobKey& key, const JobResult& result);
  // Into the map unless what is known is better.
  absl::Status TakeMatch(const MapView& view, const SessionPair& pair, const PairResult& result);
  absl::Status TakeLoops(const SubmapId& submap, const LoopResult& result);

  void CountRevisits(const MapView& view);
  // Forgets what was kept of sessions that are gone.
  void ForgetGone(const MapView& view);

  MapWriter* const map_;
  Activity* const activity_;
  storage::MapStore* const store_;
  SubmapCache* const submaps_;
  const PreparedStore prepared_store_;
  const Clock* const clock_;
  std::stop_source stop_;
  const WaitForStore wait_ = [this](const Stopwatch& since) { return WaitForStoreSince(since); };
  const Options options_;
  const ScheduleOptions schedule_;
  mutable WorkGuard guard_;
  // The serial of the last view that left nothing to do; of no view at first.
  std::atomic<uint64_t> up_to_date_with_ = ~uint64_t{0};
  // Set by the thread, told by Load.
  std::atomic<uint64_t> waiting_submaps_ = 0, waiting_pairs_ = 0, prepared_bytes_ = 0;
  // Touched by the thread only, once it runs.
  MatchingLedger ledger_;
  StoredProgress progress_;
  // Sessions with submaps left out: searches behind these are made again after the next start.
  std::set<SessionId> has_gaps_;
  JobRunner runner_;
  matching::PlaceIndex index_;
  std::map<SessionPair, std::shared_ptr<const matching::PairMemory>> pair_memories_;
  std::map<SessionId, matching::LoopMemory> memories_;  // For searches for loops.
  SessionShapes shapes_;
  matching::RevisitCounter revisits_;
  WorkerQueue queue_;
  std::thread thread_;
};

}  // namespace isthmus::server
