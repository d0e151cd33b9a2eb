// The slow loop, on a thread of its own: where sessions came back to, how two sessions' maps lie to
// each other, and which submaps have been seen again often enough. Nobody waits for it.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "server/matching/loops/loop_finder.h"
#include "server/matching/loops/revisits.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/pipeline/map_state.h"
#include "server/pipeline/prepared_store.h"
#include "server/pipeline/work_journal.h"

namespace isthmus::server {

class Estimator {
 public:
  struct Options {
    matching::MatcherOptions matcher;
    matching::LoopOptions loops;
    matching::RevisitOptions revisits;
    // A pair is tried again when its maps have grown by this many submaps; a finished session's
    // last submaps always count.
    int rematch_submaps = 1;
    // What maps kept ready may take, but for the two at hand.
    size_t prepared_bytes = size_t{128} << 20;
    // See WorkJournal; empty: none.
    std::string work_journal;
    // Told, from the thread, what was left out and why. May be null.
    std::function<void(const std::string& problem)> on_problem;
  };

  Estimator(MapState* state, storage::MapStore* store, SubmapCache* submaps, const Clock* clock,
            const Options& options);
  ~Estimator();  // Stops.

  // Nothing is under way and nothing new waits for it. The state's mutex is held by the caller.
  bool IsUpToDate() const;

  // Makes the thread end within a second or so; does not wait. What is under way is given up, to be
  // taken up at the next start.
  void Stop();

 private:
  // What a pair was last tried with: the indices that their next submaps had.
  struct Attempt {
    uint32_t next_a = 0, next_b = 0;
  };
  using Prepared = std::shared_ptr<const matching::PreparedMap>;

  // Thrown through the matcher once the thread is to end.
  struct Stopped {};

  void Run();
  // The task that comes first; false when all is up to date. `lock` is on the state's mutex, and
  // is released while the task runs.
  bool RunNext(std::unique_lock<std::mutex>* lock);

  // Does work that no record may keep from being followed by other work: what throws, or ended the
  // server before, is told and left out. False where it was not done.
  bool Guard(const std::string& task, const std::function<void()>& work);
  // Throws Stopped.
  std::shared_ptr<const matching::PreparedSubmap> GetPrepared(
      const std::shared_ptr<const Submap>& outline) const;

  // The first submap that was not asked for loops yet; only once it is placed. state mutex is held.
  std::optional<SubmapId> NextForLoops() const;
  void FindLoops(const SubmapId& submap);
  void FindLoops(const matching::LoopQuery& query);

  // The pair with the most new evidence; nothing when all is up to date. state mutex is held.
  std::optional<SessionPair> NextPair() const;
  // How many new submaps the pair has since it was tried; 0 where it is not worth a try.
  uint32_t FreshSubmaps(const SessionEntry& a, const SessionEntry& b, const Attempt& tried) const;
  void Estimate(const SessionPair& pair);
  void Estimate(const SessionMap& a, const SessionMap& b, bool finished,
                const std::optional<Match>& older);
  // Outlines of those that can be read; reads from the store.
  SessionMap MapOf(const SessionId& session,
                   const std::vector<std::shared_ptr<const SubmapInfo>>& submaps) const;
  // The map made ready for matching: made once, grown with the map.
  Prepared Prepare(const SessionMap& map);
  // Lets go of maps that were not used for long, not of the two used last.
  void LimitPrepared();

  // The map shows more submaps than when revisits were counted last. state mutex is held.
  bool MustCountRevisits() const;
  void CountRevisits();

  // Forgets what was kept of sessions that are gone. state mutex is held.
  void Prune();

  MapState* const state_;
  SubmapCache* const submaps_;
  const PreparedStore prepared_store_;
  const Clock* const clock_;
  std::stop_source stop_;  // Requested with the state's mutex held.
  const Options options_;
  WorkJournal journal_;
  const matching::SubmapSource source_;
  const SubmapReader points_;
  // Attempts since the start, whatever came of them. Guarded by the state's mutex.
  std::map<SessionPair, Attempt> attempts_;
  std::map<SessionId, uint32_t> looped_;  // The next submap to ask; guarded by the state's mutex.
  int64_t counted_revision_ = -1;         // Guarded by the state's mutex.
  // Touched by the thread only.
  std::list<Prepared> prepared_;  // The latest used first.
  std::map<SessionPair, matching::PairMatcher> matchers_;
  std::map<SessionId, matching::LoopFinder> finders_;
  matching::RevisitCounter revisits_;
  std::set<std::string> left_out_;  // Told already.
  std::thread thread_;
};

}  // namespace isthmus::server
