// A stored map that another server writes, followed by one that only reads it.
#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/datum.h"
#include "core/map/loop_closure.h"
#include "core/map/manual_decision.h"
#include "core/map/match.h"
#include "core/map/revision.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"

namespace isthmus::storage {

// Changes since the last read, all as of one commit. A field that is absent, or empty, is
// unchanged; small tables come whole.
struct StoreDelta {
  std::optional<std::vector<SessionRecord>> sessions;
  std::vector<SubmapInfo> submaps;              // New ones, in order of id.
  std::optional<std::set<SubmapId>> remaining;  // All that there are, where some are gone.
  // New entries, session by session, in order of sequence; of many, some come with the next call.
  std::vector<std::pair<SessionId, TrajectoryEntry>> trajectory;
  std::optional<std::vector<Match>> matches;
  std::optional<std::vector<ManualDecision>> manual_decisions;
  std::optional<std::vector<LoopClosure>> loops;
  std::optional<std::vector<Anchor>> anchors;
  std::optional<std::optional<Datum>> datum;
  std::optional<MapRevision> revision;  // The latest.
  bool has_events = false;              // The event log has new ones.
  std::string owner;                    // The writer of the map, for people; always told.
};

// Not thread safe.
class MapFollower {
 public:
  virtual ~MapFollower() = default;

  // News since the last call that succeeded; everything at first. Costs next to nothing if there is
  // none. Unavailable where the store cannot be reached, or has less than was read already;
  // FailedPrecondition where it cannot be followed any more, with what to do.
  virtual absl::StatusOr<StoreDelta> Next() = 0;
};

}  // namespace isthmus::storage
