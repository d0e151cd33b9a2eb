// The slow loop: estimates the transforms between sessions' maps, one pair at a time, on a thread
// of its own. Nobody waits for it.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "server/matching/matcher.h"
#include "server/matching/prepared_map.h"
#include "server/pipeline/map_state.h"
#include "server/pipeline/prepared_store.h"

namespace isthmus::server {

class Estimator {
 public:
  struct Options {
    matching::MatcherOptions matcher;
    // A pair is tried again when its maps have grown by this many submaps; a finished session's
    // last submaps always count.
    int rematch_submaps = 1;
  };

  Estimator(MapState* state, storage::MapStore* store, const Clock* clock, const Options& options);
  ~Estimator();  // Finishes the pair under way.

  // Nothing is under way and no pair has new evidence. The state's mutex is held by the caller.
  bool IsUpToDate() const { return !state_->estimating && !NextPair(); }

  // Makes the thread end after the pair under way; does not wait.
  void Stop();

 private:
  struct Attempt {
    uint32_t submaps_a = 0, submaps_b = 0;
  };

  using Prepared = std::shared_ptr<const matching::PreparedMap>;

  void Run();
  // The pair with the most new evidence; nothing when all is up to date. state mutex is held.
  std::optional<SessionPair> NextPair() const;
  void Estimate(const SessionPair& pair);
  // Forgets what was kept of sessions that are gone. state mutex is held.
  void Prune();
  // The map made ready for matching: made once, grown with the map.
  Prepared Prepare(const SessionMap& map);

  MapState* const state_;
  const PreparedStore prepared_store_;
  const Clock* const clock_;
  const Options options_;
  // Attempts since the start, whatever came of them. Guarded by the state's mutex.
  std::map<SessionPair, Attempt> attempts_;
  bool stop_ = false;             // Guarded by the state's mutex.
  std::list<Prepared> prepared_;  // Touched by the thread only; the latest used first.
  std::map<SessionPair, matching::PairMatcher> matchers_;  // Touched by the thread only.
  std::thread thread_;
};

}  // namespace isthmus::server
