// The ledger of matching: all that it has tried and given away, by which its next job is chosen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/ids.h"
#include "core/stopwatch.h"
#include "server/jobs/job_key.h"
#include "server/matching/index/place_index.h"
#include "storage/map_records.h"

namespace isthmus::server {

using storage::SessionPair;

// The state in which a pair was last tried; a pair that never was has an empty one.
struct Attempt {
  uint32_t next_a = 0, next_b = 0;    // SessionView::next_index.
  uint32_t shape_a = 0, shape_b = 0;  // MatchingLedger::shapes.
  uint64_t anchors = 0;               // AnchorIndex::Version.
};

// Pairs of a session that were tried: all, those that were searched, beyond a first look, and
// those within a component.
struct PairCounts {
  size_t pairs = 0, searched = 0, joined = 0;
};

// The number of pairs of a session that may be tried, as of when it had so many submaps.
struct PairBudget {
  PairCounts up_to;
  uint32_t next_index = 0;

  bool HasRoom(const PairCounts& tried) const {
    return tried.pairs < up_to.pairs && tried.searched < up_to.searched;
  }
  // The same for sessions beside it: however many strangers were tried.
  bool HasRoomNear(const PairCounts& tried) const { return tried.joined < up_to.joined; }
};

// Value type.
struct MatchingLedger {
  // Makes `key` due again, as if it had never been tried.
  void Forget(const JobKey& key);
  // Lets go of sessions that `view` does not have.
  void ForgetGone(const storage::MapRecords& view);

  std::map<SessionPair, Attempt> attempts;  // Since the start, whatever came of them.
  std::optional<SessionPair> last_pair;     // The last of these.
  std::vector<SessionPair> unfinished;      // Chosen before the start, and ended at.
  std::map<SessionId, uint32_t> looped;     // The next submap to search for loops.
  std::map<SessionId, uint32_t> indexed;    // The next submap when it was compared with others.
  std::map<SessionId, PairBudget> allowed;
  std::vector<matching::RankedPair> ranked;  // By the index, as of its last change.
  // Sessions with loops: SessionShapes::version, and the ones whose shape has to be updated.
  std::map<SessionId, uint32_t> shapes;
  std::set<SessionId> outdated_shapes;
  std::map<JobKey, Stopwatch> posted;  // Others are at them, since then.
  int64_t counted_revision = -1;       // Its submaps were counted as seen again.
};

}  // namespace isthmus::server
