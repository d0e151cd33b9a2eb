// The records of a map as batches change them, without points, scans' poses, checkpoints and
// history: one meaning of a batch for the memory store and for the server's view of the map.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/concurrency/shared_map.h"
#include "core/map/anchor.h"
#include "core/map/datum.h"
#include "core/map/loop_closure.h"
#include "core/map/manual_decision.h"
#include "core/map/match.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "storage/map_store.h"

namespace isthmus::storage {

using SessionPair = std::pair<SessionId, SessionId>;  // first < second

struct SessionRecords {
  SessionRecord record;
  SharedMap<uint32_t, SubmapInfo> submaps;  // By index; gaps are submaps that were retired.
  uint64_t points = 0;                      // Points in all of them.
  // By submap: the sensor's way from its first scan to the first of the next one.
  SharedMap<uint32_t, double> path_length_m;
  std::optional<TrajectoryEntry> last_pose;  // The newest scan's.

  // The index that the next submap has: it grows with any retirement, because the newest never is.
  uint32_t next_index() const { return submaps.empty() ? 0 : submaps.back().id.index + 1; }
};

// Copies share their equal parts, so a copy costs next to nothing.
struct MapRecords {
  SharedMap<SessionId, SessionRecords> sessions;
  SharedMap<SessionPair, Match> matches;  // As computed.
  SharedMap<SessionPair, ManualDecision> manual_decisions;
  SharedMap<uint64_t, LoopClosure> loops;  // By id.
  SharedMap<SubmapId, Anchor> anchors;
  std::optional<Datum> datum;
};

using SubmapInfos = std::vector<std::shared_ptr<const SubmapInfo>>;

// Summaries of the batch's submaps, in their order. Bounds take a pass over the points.
SubmapInfos SummarizeSubmaps(const WriteBatch& batch);

// As WriteBatch says; `infos` stand for its submaps. Records of a session that is not there are
// passed over; a store has refused them.
void Apply(const WriteBatch& batch, const SubmapInfos& infos, MapRecords* records);

// Removes the session and its later segments with everything that belongs to them. Returns their
// ids.
std::set<SessionId> RemoveSession(const SessionId& session, MapRecords* records);

}  // namespace isthmus::storage
