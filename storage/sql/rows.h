// Records to rows and back, table by table. Every function runs on the connection it is given,
// inside the transaction that is open there if any; `key`s are those of the tables (see
// migrations/).
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/map/manual_decision.h"
#include "core/map/match.h"
#include "core/map/revision.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "storage/map_store.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

// sessions. Replaces by id.
absl::Status PutSession(Connection& database, const SessionRecord& record);
absl::StatusOr<std::optional<SessionRecord>> FindSession(Connection& database,
                                                         const SessionId& session);
// Absent for an unknown session.
absl::StatusOr<std::optional<int64_t>> FindSessionKey(Connection& database,
                                                      const SessionId& session);
absl::StatusOr<std::vector<SessionRecord>> SelectSessions(Connection& database);
// Takes along all that belongs to it. False if there was none.
absl::StatusOr<bool> RemoveSession(Connection& database, const SessionId& session);
// The size of the blobs of submaps and features.
absl::StatusOr<uint64_t> SumBytes(Connection& database, int64_t session_key);

// checkpoints. Replaces by session; removing one that is not there is no error. A checkpoint that
// is found names no session.
absl::Status PutCheckpoint(Connection& database, const Checkpoint& checkpoint);
absl::Status RemoveCheckpoint(Connection& database, const SessionId& session);
absl::StatusOr<std::optional<Checkpoint>> FindCheckpoint(Connection& database, int64_t session_key);

// matching_progress. Replaces by session.
absl::Status PutMatchingProgress(Connection& database, const MatchingProgress& progress);
absl::StatusOr<std::vector<MatchingProgress>> SelectMatchingProgress(Connection& database);

// trajectory. An entry whose sequence is there already is left as it is.
absl::Status AddTrajectory(Connection& database,
                           const std::vector<std::pair<SessionId, TrajectoryEntry>>& entries);
absl::StatusOr<std::vector<TrajectoryEntry>> SelectTrajectory(Connection& database,
                                                              int64_t session_key);
// Reads columns sequence, stamp_ns, submap_index and T_odom_sensor.
TrajectoryEntry ReadTrajectoryEntry(const Statement& row);

// submaps, submap_blobs. `blob` is EncodeSubmap's.
struct SubmapRow {
  SubmapInfo info;
  std::string blob;
};
absl::Status AddSubmap(Connection& database, const SubmapRow& submap);
// For a row that has none; no error where there is no such row.
absl::Status FillInContent(Connection& database, const SubmapId& submap, uint64_t content);
// DataLoss, naming it, for a row that is not whole.
absl::StatusOr<std::shared_ptr<const Submap>> UnpackSubmap(const SubmapRow& submap);
// With that reason.
absl::Status DamagedSubmap(const SubmapId& submap, const absl::Status& why);
// With its scans and all that hangs on it; one that is not there is no error.
absl::Status RemoveSubmap(Connection& database, int64_t session_key, uint32_t index);
absl::StatusOr<std::optional<int64_t>> FindSubmapKey(Connection& database, const SubmapId& submap);
// NotFound where there is none; DataLoss, naming it, where not all of it is there any more.
absl::StatusOr<SubmapRow> FindSubmap(Connection& database, const SubmapId& submap);
// All sessions when the key is absent; in order of (session id, index).
absl::StatusOr<std::vector<SubmapInfo>> SelectSubmaps(Connection& database,
                                                      std::optional<int64_t> session_key);
// Submaps whose rows came behind the one of that key, in the same order.
absl::StatusOr<std::vector<SubmapInfo>> SelectSubmapsBehind(Connection& database, int64_t key);
absl::StatusOr<std::vector<SubmapId>> SelectSubmapIds(Connection& database);

// All tables. Does as MapStore::Write promises, but for committing; after an error the caller takes
// the changes back. `submaps` are the batch's, encoded.
absl::Status AddBatch(Connection& database, const WriteBatch& batch,
                      const std::vector<SubmapRow>& submaps);

// features. NotFound where the submap, or the kind, is unknown; DataLoss for a wrong checksum.
absl::Status PutFeatureRow(Connection& database, const FeatureBlob& blob);
absl::StatusOr<std::string> FindFeatures(Connection& database, const SubmapId& submap,
                                         const std::string& kind);

// matches, match_stages. Replaces by pair. Edges that are damaged are left out.
absl::Status PutMatch(Connection& database, const Match& match);
absl::StatusOr<std::vector<Match>> SelectMatches(Connection& database);
// kNotYet for a name that is not known.
MatchState ParseState(const std::string& name);

// match_rivals, by the keys of the match's sessions.
using KeyPair = std::pair<int64_t, int64_t>;
absl::Status InsertRivals(Connection& database, const KeyPair& keys,
                          const std::vector<RivalMatch>& rivals);
absl::StatusOr<std::map<KeyPair, std::vector<RivalMatch>>> SelectRivals(Connection& database);

// verdicts. Replaces by pair; removing one that is not there is no error.
absl::Status PutManualDecision(Connection& database, const ManualDecision& manual_decision);
absl::Status RemoveManualDecision(Connection& database, const SessionId& a, const SessionId& b);
absl::StatusOr<std::vector<ManualDecision>> SelectManualDecisions(Connection& database);

// loops. Replaces by id. Loops with damaged edges are left out.
absl::Status PutLoop(Connection& database, const LoopClosure& loop);
absl::StatusOr<std::vector<LoopClosure>> SelectLoops(Connection& database);
// Removes the session's loops of which no edge is left with both its submaps.
absl::Status RemoveLostLoops(Connection& database, int64_t session_key);

// anchors. Replaces by submap; removing one that is not there is no error.
absl::Status PutAnchor(Connection& database, const Anchor& anchor);
absl::Status RemoveAnchor(Connection& database, const SubmapId& submap);
absl::StatusOr<std::vector<Anchor>> SelectAnchors(Connection& database);

// datum.
absl::Status SetDatum(Connection& database, const std::optional<Datum>& datum);
absl::StatusOr<std::optional<Datum>> SelectDatum(Connection& database);

// events. Numbers them, and lets the oldest go, as map_store.h says.
absl::Status AddEvents(Connection& database, const std::vector<Event>& events);
absl::StatusOr<EventPage> SelectEvents(Connection& database, const EventQuery& query);

// revisions, revision_matches, revision_loops, placements, and the moves. Prunes as map_store.h
// says.
absl::Status AddRevision(Connection& database, const MapRevision& revision,
                         const std::vector<SubmapMove>& moves);
absl::StatusOr<int64_t> LatestRevisionNumber(Connection& database);
// The oldest that SelectMoves may be asked from.
absl::StatusOr<int64_t> OldestComparableRevision(Connection& database);
absl::StatusOr<std::vector<RevisionInfo>> SelectRevisions(Connection& database, int limit);
absl::StatusOr<MapRevision> SelectLatestRevision(Connection& database);

// submap_moves, placed_submaps.
absl::Status AddMoves(Connection& database, int64_t revision, const std::vector<SubmapMove>& moves);
absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> SelectMoves(Connection& database,
                                                                        int64_t from, int64_t to);
absl::StatusOr<std::vector<SubmapPose>> SelectPlacedSubmaps(Connection& database,
                                                            const SessionId& session);

}  // namespace isthmus::storage
