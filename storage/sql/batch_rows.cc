#include <set>

#include "storage/batch_rules.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

absl::Status Check(Connection& database, const WriteBatch& batch) {
  absl::Status failure;  // An error of the queries themselves.
  const auto exists = [&](const auto& key) {
    if (failure.ok() && !key.ok()) failure = key.status();
    return key.ok() && key->has_value();
  };
  absl::StatusOr<int64_t> latest = LatestRevisionNumber(database);
  if (!latest.ok()) return latest.status();
  StoreContents contents;
  contents.has_session = [&](const SessionId& id) { return exists(FindSessionKey(database, id)); };
  contents.has_submap = [&](const SubmapId& id) { return exists(FindSubmapKey(database, id)); };
  contents.latest_revision = *latest;
  absl::Status status = CheckBatch(batch, contents);
  return failure.ok() ? status : failure;
}

absl::Status Retire(Connection& database, const std::vector<SubmapId>& retired) {
  std::set<int64_t> sessions;
  for (const SubmapId& submap : retired) {
    absl::StatusOr<std::optional<int64_t>> session = FindSessionKey(database, submap.session);
    if (!session.ok()) return session.status();
    if (!*session) continue;
    sessions.insert(**session);
    const absl::Status status = RemoveSubmap(database, **session, submap.index);
    if (!status.ok()) return status;
  }
  for (const int64_t session : sessions) {
    if (auto status = RemoveLostLoops(database, session); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status WriteCheckpoints(Connection& database, const WriteBatch& batch) {
  for (const Checkpoint& checkpoint : batch.checkpoints) {
    if (absl::Status status = PutCheckpoint(database, checkpoint); !status.ok()) return status;
  }
  for (const SessionRecord& record : batch.sessions) {
    if (record.state != SessionState::kFinished) continue;
    if (absl::Status status = RemoveCheckpoint(database, record.id); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// The records that came with placing submaps.
absl::Status WriteGraphRows(Connection& database, const WriteBatch& batch) {
  for (const LoopClosure& loop : batch.loops) {
    if (absl::Status status = PutLoop(database, loop); !status.ok()) return status;
  }
  for (const Anchor& anchor : batch.anchors) {
    if (absl::Status status = PutAnchor(database, anchor); !status.ok()) return status;
  }
  for (const SubmapId& submap : batch.removed_anchors) {
    if (absl::Status status = RemoveAnchor(database, submap); !status.ok()) return status;
  }
  if (batch.datum) {
    if (absl::Status status = SetDatum(database, *batch.datum); !status.ok()) return status;
  }
  if (absl::Status status = Retire(database, batch.retired); !status.ok()) return status;
  if (absl::Status status = AddEvents(database, batch.events); !status.ok()) return status;
  if (!batch.revision) return absl::OkStatus();
  return AddRevision(database, *batch.revision, batch.moves);
}

}  // namespace

absl::Status AddBatch(Connection& database, const WriteBatch& batch,
                      const std::vector<SubmapRow>& submaps) {
  if (absl::Status status = Check(database, batch); !status.ok()) return status;
  for (const SessionRecord& record : batch.sessions) {
    if (absl::Status status = PutSession(database, record); !status.ok()) return status;
  }
  if (auto status = AddTrajectory(database, batch.trajectory); !status.ok()) return status;
  for (const SubmapRow& submap : submaps) {
    if (auto status = AddSubmap(database, submap); !status.ok()) return status;
  }
  for (const auto& [submap, content] : batch.contents) {
    if (auto status = FillInContent(database, submap, content); !status.ok()) return status;
  }
  if (absl::Status status = WriteCheckpoints(database, batch); !status.ok()) return status;
  for (const MatchingProgress& progress : batch.matching_progress) {
    if (auto status = PutMatchingProgress(database, progress); !status.ok()) return status;
  }
  for (const Match& match : batch.matches) {
    if (absl::Status status = PutMatch(database, match); !status.ok()) return status;
  }
  for (const ManualDecision& manual_decision : batch.manual_decisions) {
    if (absl::Status status = PutManualDecision(database, manual_decision); !status.ok())
      return status;
  }
  for (const auto& [a, b] : batch.withdrawn_decisions) {
    if (absl::Status status = RemoveManualDecision(database, a, b); !status.ok()) return status;
  }
  return WriteGraphRows(database, batch);
}

}  // namespace isthmus::storage
