// What the server knows right now, in one place behind one lock: sessions, their submaps, the
// matches, where everything is placed, and what is still to be done.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/composed_map.h"
#include "core/match.h"
#include "core/revision.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "core/verdict.h"
#include "server/ingest/session_worker.h"
#include "server/match_graph/match_graph.h"
#include "storage/map_store.h"

namespace isthmus::server {

using SessionPair = std::pair<SessionId, SessionId>;  // first < second

struct SessionEntry {
  SessionRecord record;
  std::shared_ptr<ingest::SessionWorker> worker;  // Null once finished: its local map is large.
  ingest::WorkerStatus final_status;              // What the worker said last.
  std::vector<std::shared_ptr<const Submap>> submaps;
  std::vector<TrajectoryEntry> trajectory;  // Durable part.
  uint64_t points = 0;
  bool uploads = false;  // Holds uploaded submaps, so takes no scans.
};

// Every public member names whether it locks; `mutex` is public because readers compose several
// looks into one consistent answer.
class MapState {
 public:
  MapState(storage::MapStore* store, const Clock* clock) : store_(store), clock_(clock) {}

  // Reads everything back from the store. Call once, before any thread starts.
  absl::Status Load();

  // --- mutex held by the caller ---
  SessionEntry* Find(const SessionId& session);
  // The robot's newest session; null if unknown.
  SessionEntry* Newest(const RobotId& robot);
  const Placement* PlacementOf(const SessionId& session) const;
  // What the graph is made of: the computed match of the pair under what a person said of it, and
  // set aside where others speak against it; nothing where nothing is known of the pair.
  std::optional<Match> EffectiveMatch(const SessionPair& pair) const;
  // In order of the pairs.
  std::vector<Match> EffectiveMatches() const { return effective_; }
  // All submaps with their placements, for composition.
  std::vector<PlacedSubmap> PlacedSubmaps() const;
  // `map` shows the latest revision with every submap.
  bool IsComposed() const {
    return composed_revision == revision.revision && composed_version == submap_version;
  }

  // --- these lock ---
  // Stores a finished stretch, adds it to its session, places the session if it is new.
  absl::Status AddStretch(const SessionId& session, const ingest::Stretch& stretch);
  // Stores the match and places everything anew. Ignored when a session is gone.
  absl::Status PutMatch(const Match& match);
  // Stores what a person said and places everything anew. Both sessions must exist.
  absl::Status PutVerdict(const Verdict& verdict);
  absl::Status WithdrawVerdict(const SessionId& a, const SessionId& b);
  // Removes the session from store and state, places the rest anew.
  absl::Status RemoveSession(const SessionId& session);
  void ScanQueued();
  void ScanDone();

  std::mutex mutex;
  // Notified whenever anything below changes.
  std::condition_variable changed;

  // --- guarded by mutex ---
  std::map<SessionId, SessionEntry> sessions;
  std::map<SessionPair, Match> matches;  // As computed.
  std::map<SessionPair, Verdict> verdicts;
  MapRevision revision;
  std::vector<SessionPair> tree;
  uint64_t pending_scans = 0;
  uint64_t submap_version = 0;     // Grows with every submap added or removed.
  bool estimating = false;         // The estimator is at work on a pair.
  int64_t composed_revision = -1;  // What `map` was made of.
  uint64_t composed_version = 0;
  double composition_ms = 0, composition_max_ms = 0, estimation_ms = 0;
  uint64_t compositions = 0, estimations = 0;
  std::shared_ptr<const ComposedMap> map;

 private:
  // Solves the match graph; when placements differ from the latest, a new revision is made and
  // stored. mutex is held.
  absl::Status Replace(const std::string& cause);
  // Every pair of which anything was computed or said, checked round cycles. mutex is held.
  std::vector<Match> Combine(const std::vector<match_graph::Node>& nodes) const;

  storage::MapStore* const store_;
  const Clock* const clock_;
  std::vector<Match> effective_;  // As of the last Replace; guarded by mutex.
};

}  // namespace isthmus::server
