// The store of sessions, submaps, trajectories, matches and revisions: the promise that every store
// keeps; sqlite_store.h keeps it on disk, memory_store.h until the process ends.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
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
#include "core/records/event.h"
#include "storage/job_queue.h"

namespace isthmus::storage {

// A session worker's state after a scan, from which it can go on exactly.
struct Checkpoint {
  SessionId session = {};
  uint64_t sequence = 0;  // The last scan that was dealt with.
  // Scans up to here are safe even without `data`; at most `sequence`.
  uint64_t durable_sequence = 0;
  // Opaque. Absent, when read, where it is damaged: the numbers are known nevertheless.
  std::optional<std::string> data = {};
};

// The progress of matching with a session: a server that starts goes on there.
struct MatchingProgress {
  SessionId session = {};
  uint32_t next_for_loops = 0;  // Submaps before this index were searched for loops.
  // The index that its next submap had when its partners were last chosen; 0: never.
  uint32_t next_at_choice = 0;
  // Pairs of it that may be tried since then: all, those that are searched beyond a first look, and
  // those within its component.
  uint64_t max_pairs = 0, max_searched = 0, max_joined = 0;

  friend bool operator==(const MatchingProgress&, const MatchingProgress&) = default;
};

// Changes that take effect together or not at all.
struct WriteBatch {
  // Inserted, or replaced by id; a later segment after its first. One that is finished loses its
  // checkpoint.
  std::vector<SessionRecord> sessions = {};
  // Inserted, or replaced by session; with `data`.
  std::vector<Checkpoint> checkpoints = {};
  std::vector<MatchingProgress> matching_progress = {};  // Inserted, or replaced by session.
  // Appended to a session's trajectory; a sequence that is there already is left as it is.
  std::vector<std::pair<SessionId, TrajectoryEntry>> trajectory = {};
  // Inserted; an id that exists is an error.
  std::vector<std::shared_ptr<const Submap>> submaps = {};
  // Inserted, or replaced by the pair (a, b). All but the residuals of cycles, which follow from
  // the other matches and come back as -1.
  std::vector<Match> matches = {};
  std::vector<ManualDecision> manual_decisions = {};  // Inserted, or replaced by the pair (a, b).
  // Pairs whose manual decision is removed; one without is left as it is.
  std::vector<std::pair<SessionId, SessionId>> withdrawn_decisions = {};
  // Inserted, or replaced by id. An edge with a submap that is not there any more stays.
  std::vector<LoopClosure> loops = {};
  std::vector<Anchor> anchors = {};            // Inserted, or replaced by submap.
  std::vector<SubmapId> removed_anchors = {};  // One that is not there is left as it is.
  // The datum as it is from now on, or that there is none; absent: as it was.
  std::optional<std::optional<Datum>> datum = {};
  // ContentOf submaps whose rows have none, as of older versions; others are left as they are.
  std::vector<std::pair<SubmapId, uint64_t>> contents = {};
  // Submaps that leave with all that was kept of them: points, features, anchor, the poses of their
  // scans, and the loop closures of which no edge is left with both its submaps. Unknown ones are
  // left as they are.
  std::vector<SubmapId> retired = {};
  // Becomes the latest; must be newer. `moves` are the differences of its submaps from those of the
  // one before, each submap once: LatestRevision's submaps follow from the moves alone, and the
  // submaps of its placements here are not looked at.
  std::optional<MapRevision> revision = {};
  std::vector<SubmapMove> moves = {};
  // Appended to the event log, in this order; the store gives them their numbers.
  std::vector<Event> events = {};
};

// History goes back this far: older revisions go, each with all its moves, but never the latest.
inline constexpr int kRevisionsKept = 1000;
inline constexpr int64_t kMovesKept = 200'000;

// Events that are kept; the oldest go. Some 30 MB at most of usual ones, and weeks of a busy site:
// robots make a few an hour.
inline constexpr size_t kEventsKept = 100'000;

// Bytes on disk.
struct StoreSize {
  uint64_t database = 0;
  uint64_t log = 0;  // The write-ahead log.
};

// Features of a submap kept for matching: an opaque blob under a kind ("prepared-v1").
struct FeatureBlob {
  SubmapId submap;
  std::string kind;
  std::string data;
};

// Thread safe. Errors: NotFound for unknown ids, AlreadyExists for a submap id that exists,
// FailedPrecondition for a submap, pose, checkpoint, progress or segment of a session that does not
// exist or a revision that is not newer, InvalidArgument for a record that breaks its own type's
// promise (batch_rules.h), DataLoss for a record whose checksum is wrong, ResourceExhausted when
// the disk is full, Unavailable when the store cannot be reached.
class MapStore {
 public:
  virtual ~MapStore() = default;

  // Once this returns OK the whole batch survives the death of the process and, for a store on
  // disk, of the machine. Otherwise nothing of it has happened.
  virtual absl::Status Write(const WriteBatch& batch) = 0;

  // Removes a session and its later segments with their trajectories, submaps, features, matches,
  // manual decisions, loop closures, anchors, checkpoint and matching progress, and appends the
  // events, all or nothing. NotFound if unknown.
  virtual absl::Status DeleteSession(const SessionId& session,
                                     const std::vector<Event>& events) = 0;
  absl::Status DeleteSession(const SessionId& session) { return DeleteSession(session, {}); }

  virtual absl::StatusOr<SessionRecord> GetSession(const SessionId& session) const = 0;
  // In order of creation.
  virtual absl::StatusOr<std::vector<SessionRecord>> ListSessions() const = 0;

  // Costs next to nothing and waits for no reader or writer. Zeros in memory, or where the disk
  // does not tell.
  virtual StoreSize SizeOnDisk() const { return {}; }

  // The size of the session's submaps and their features, about; everything else stored about it is
  // small.
  virtual absl::StatusOr<uint64_t> StoredBytes(const SessionId& session) const = 0;

  // In order of sequence; empty for a session without scans.
  virtual absl::StatusOr<std::vector<TrajectoryEntry>> GetTrajectory(
      const SessionId& session) const = 0;

  // The last one of the session; NotFound where there is none. One whose data is damaged comes
  // without.
  virtual absl::StatusOr<Checkpoint> GetCheckpoint(const SessionId& session) const = 0;

  // In order of session; those with which matching has not begun are left out.
  virtual absl::StatusOr<std::vector<MatchingProgress>> ListMatchingProgress() const = 0;

  virtual absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& submap) const = 0;
  // In order of index. All sessions when `session` is absent.
  virtual absl::StatusOr<std::vector<SubmapInfo>> ListSubmaps(
      const std::optional<SessionId>& session) const = 0;

  // In order of (a, b). A match whose edges are damaged comes without them.
  virtual absl::StatusOr<std::vector<Match>> ListMatches() const = 0;

  // In order of (a, b).
  virtual absl::StatusOr<std::vector<ManualDecision>> ListManualDecisions() const = 0;

  // In order of id. A loop closure whose edges are damaged is left out: it is nothing without.
  virtual absl::StatusOr<std::vector<LoopClosure>> ListLoops() const = 0;

  // In order of submap.
  virtual absl::StatusOr<std::vector<Anchor>> ListAnchors() const = 0;

  virtual absl::StatusOr<std::optional<Datum>> GetDatum() const = 0;

  // Revision 0 without placements where none was ever written. Sessions deleted and submaps retired
  // since may be named. Placements written before submaps were placed one by one have none.
  virtual absl::StatusOr<MapRevision> LatestRevision() const = 0;
  // The newest at most `limit` of those still kept, the newest first; see kRevisionsKept.
  virtual absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) const = 0;
  // The moves of revisions after `from` up to `to`, each with its number, in order of revision and
  // then of submap; nothing when from >= to. OutOfRange, naming the oldest that can be compared
  // with, when `from` is older; NotFound when `to` is newer than the latest.
  virtual absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> ListMoves(
      int64_t from, int64_t to) const = 0;

  // See kEventsKept. Numbers count from 1 and have no gaps.
  virtual absl::StatusOr<EventPage> ListEvents(const EventQuery& query) const = 0;

  // Replaces the blob kept under the same submap and kind. Durable like Write.
  virtual absl::Status PutFeatures(const FeatureBlob& blob) = 0;
  // NotFound when nothing was kept.
  virtual absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                                  const std::string& kind) const = 0;

  // True if it is reached over a network: Unavailable says that it is away as a whole, and is worth
  // waiting for. On a disk it may be this record's for ever.
  virtual bool IsRemote() const { return false; }

  // The store's own queue, where workers reach the map as well; else null.
  virtual JobQueue* jobs() { return nullptr; }
};

}  // namespace isthmus::storage
