// The schedule of matching: which job is next, by the map and the ledger alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "server/jobs/job_key.h"
#include "server/map/map_view.h"
#include "server/threads/limits.h"
#include "server/threads/matching_ledger.h"
#include "server/threads/session_proximity.h"

namespace isthmus::server {

struct ScheduleOptions {
  bool find_loops = true;
  bool count_revisits = true;
  // A pair is tried again when its maps have grown by this many submaps; a finished session's
  // last submaps always count.
  int rematch_submaps = 1;
};

struct NextJob {
  std::optional<JobKey> key;  // Nothing when all is up to date, or given away.
  uint64_t waiting_submaps = 0;
  std::optional<uint64_t> waiting_pairs;  // Nothing where others come first: they are not counted.
};

// First searches for loops and shapes, as they straighten the maps that pairs are matched by; then
// sessions to compare, pairs, and the count of submaps seen again.
NextJob ChooseNext(const MapView& view, const MatchingLedger& ledger,
                   const ScheduleOptions& options);

// The first submap that is to be searched for loops; only once it is placed, and nobody is at the
// one before: its place follows from theirs.
std::optional<SubmapId> NextForLoops(const MapView& view, const MatchingLedger& ledger,
                                     const ScheduleOptions& options);

// The purpose of a match.
struct MatchTrigger {
  bool last_submaps = false;  // No more will come.
  bool first_look = false;    // One of many: a first look tells if it is worth a search.
};
MatchTrigger TriggerOf(const MapView& view, const MatchingLedger& ledger, const SessionPair& pair,
                       const ScheduleOptions& options);

// An attempt at the pair as both sessions are now.
Attempt AttemptNow(const MapView& view, const MatchingLedger& ledger, const SessionPair& pair);

// The attempt by which a match of so many submaps was computed then.
Attempt AttemptOf(const MapView& view, const SessionPair& pair, uint32_t submaps_a,
                  uint32_t submaps_b, int64_t computed_ns);

// With few sessions all pairs are searched.
bool SelectsPartners(const MapView& view);

// The number of tried pairs of each session.
std::map<SessionId, PairCounts> CountTried(const MapView& view, const SessionProximity& proximity,
                                           const MatchingLedger& ledger);

inline bool IsFinished(const SessionView& session) {
  return session.record.state == SessionState::kFinished;
}

// Has enough points for any match; see kLeastMatchedPoints.
inline bool IsMatchable(const SessionView& session) {
  return !session.submaps.empty() && session.points >= kLeastMatchedPoints;
}

}  // namespace isthmus::server
