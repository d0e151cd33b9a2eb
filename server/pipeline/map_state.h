// What the server knows right now, in one place behind one lock: sessions, their submaps, the
// matches, where everything is placed, and what is still to be done.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/anchor.h"
#include "core/clock.h"
#include "core/composed_map.h"
#include "core/loop_closure.h"
#include "core/match.h"
#include "core/revision.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "core/verdict.h"
#include "server/ingest/session_worker.h"
#include "server/match_graph/match_graph.h"
#include "server/pipeline/submap_cache.h"
#include "server/placement/placer.h"
#include "storage/map_store.h"

namespace isthmus::server {

using SessionPair = std::pair<SessionId, SessionId>;  // first < second

struct SessionEntry {
  SessionRecord record;
  std::shared_ptr<ingest::SessionWorker> worker;  // Null once finished: its local map is large.
  ingest::WorkerStatus final_status;              // What the worker said last.
  // In order of index; gaps are submaps that were retired. Their points are read when needed.
  std::vector<std::shared_ptr<const SubmapInfo>> submaps;
  std::map<uint32_t, double> way_m;          // By submap: how far its scans went.
  std::optional<TrajectoryEntry> last_pose;  // The newest that is durable.
  uint64_t points = 0;
  bool uploads = false;  // Holds uploaded submaps, so takes no scans.

  // The index that the next submap has: it grows whatever is retired, because the newest never is.
  uint32_t next_index() const { return submaps.empty() ? 0 : submaps.back()->id.index + 1; }
  // Null for one that is not there.
  std::shared_ptr<const SubmapInfo> FindSubmap(uint32_t index) const;
  // A scan whose pose is durable; in order of sequence.
  void AddPose(const TrajectoryEntry& pose);
};

// What a person says at once.
struct Word {
  std::vector<Verdict> verdicts = {};
  std::vector<SessionPair> withdrawn = {};  // Whose verdicts are taken back.
  std::vector<LoopClosure> loops = {};      // As they are from now on.
};

// What came since the map was placed last: why the next revision is made.
struct Changes {
  std::vector<std::string> causes;  // For a person; the first few.
  std::vector<SessionPair> matches;
  std::vector<uint64_t> loops;
};

// Every public member names whether it locks; `mutex` is public because readers compose several
// looks into one consistent answer.
class MapState {
 public:
  // `cache` is told which submaps come and go.
  MapState(storage::MapStore* store, SubmapCache* cache, const Clock* clock)
      : store_(store), cache_(cache), clock_(clock) {}

  // Reads everything back from the store. Call once, before any thread starts.
  absl::Status Load();

  // --- mutex held by the caller ---
  SessionEntry* Find(const SessionId& session);
  // The robot's newest session, where that has several segments the last; null if unknown.
  SessionEntry* Newest(const RobotId& robot);
  // Of the session that a robot opened, in order; none for another id.
  std::vector<SessionEntry*> SegmentsOf(const SessionId& opened);
  std::vector<const SessionEntry*> SegmentsOf(const SessionId& opened) const;
  const Placement* PlacementOf(const SessionId& session) const;
  // What the graph is made of: the computed match of the pair under what a person said of it, and
  // set aside where others speak against it; nothing where nothing is known of the pair.
  std::optional<Match> EffectiveMatch(const SessionPair& pair) const;
  // In order of the pairs.
  std::vector<Match> EffectiveMatches() const { return effective_; }
  // All submaps with their placements, for composition.
  std::vector<PlacedSubmap> PlacedSubmaps() const;
  // The sessions that have submaps.
  std::vector<match_graph::Node> MatchGraphNodes() const;
  // What the graph is made of at present.
  placement::Input PlacementInput() const;
  // Nothing has changed that `revision` does not show.
  bool IsPlaced() const { return placed_version == graph_version; }
  // `map` shows the latest revision.
  bool IsComposed() const { return composed_revision == revision.revision; }

  // --- these lock ---
  // All that change the graph return when the change is stored; the map is placed anew soon after
  // (WaitUntilPlaced).

  // Stores a finished stretch, or a checkpoint alone, and adds what it holds to its segment of the
  // session. A segment that there is none of yet is opened with it.
  absl::Status AddStretch(const SessionId& session, const ingest::Stretch& stretch);
  // Ignored when a session is gone.
  absl::Status PutMatch(const Match& match);
  // Stores what a person said of pairs and of loop closures, all or nothing. All must exist.
  absl::Status PutWord(const Word& word);
  // New ones; gives them their ids. Ignored when the session is gone.
  absl::Status AddLoops(std::vector<LoopClosure> found);
  absl::Status PutAnchor(const Anchor& anchor);
  absl::Status RemoveAnchor(const SubmapId& submap);
  // Removes the submaps with all that hangs on them.
  absl::Status Retire(const std::vector<SubmapId>& submaps);
  // Removes the session, all its segments, from store and state. `why` is said in the revision's
  // cause.
  absl::Status RemoveSession(const SessionId& session, const std::string& why = "");
  // Until `revision` shows what the state says now, or nothing is placed any more.
  void WaitUntilPlaced();
  void ScanQueued();
  void ScanDone();

  std::mutex mutex;
  // Notified whenever anything below changes.
  std::condition_variable changed;

  // How many sessions were removed so far. Grows with mutex held; read by who is at work on what
  // there was, without it.
  std::atomic<uint64_t> removals = 0;

  // --- guarded by mutex ---
  std::map<SessionId, SessionEntry> sessions;
  std::map<SessionPair, Match> matches;  // As computed.
  std::map<SessionPair, Verdict> verdicts;
  std::map<uint64_t, LoopClosure> loops;  // By id.
  std::map<SubmapId, Anchor> anchors;
  MapRevision revision;
  std::vector<SessionPair> tree;
  placement::Judgement judgement;  // Which edges `revision` agrees with.
  uint64_t pending_scans = 0;
  uint64_t graph_version = 0;      // Grows with everything that placements rest on.
  uint64_t placed_version = 0;     // That which `revision` shows.
  bool placing = true;             // False once nothing will be placed any more.
  Changes changes;                 // Since placed_version.
  bool estimating = false;         // The estimator is at work.
  int64_t composed_revision = -1;  // What `map` was made of.
  double composition_ms = 0, composition_max_ms = 0, estimation_ms = 0, placement_ms = 0;
  uint64_t compositions = 0, estimations = 0, placements = 0;
  uint64_t retired = 0;
  std::map<SubmapId, std::string> damaged;  // Submaps that cannot be read, and why.
  std::shared_ptr<const ComposedMap> map;

 private:
  absl::Status LoadSession(const SessionRecord& record);
  // Those of its segments that the stretch brings, as they are to be stored.
  std::vector<SessionRecord> NewSegments(const SessionId& session, const ingest::Stretch& stretch);
  absl::Status LoadLoops();
  // Takes note of a change. mutex is held.
  void Changed(const std::string& cause);
  // Works out the effective matches anew: when matches, verdicts or the sessions in the graph
  // change. mutex is held.
  void RefreshMatches();

  storage::MapStore* const store_;
  SubmapCache* const cache_;
  const Clock* const clock_;
  std::vector<Match> effective_;  // Under verdicts and cycles; guarded by mutex.
  // No number is given twice while a revision names it, gone though its loop closure be: who undoes
  // that revision means the old one. Guarded by mutex.
  uint64_t next_loop_ = 1;
};

}  // namespace isthmus::server
