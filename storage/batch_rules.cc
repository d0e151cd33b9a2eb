#include "storage/batch_rules.h"

#include <absl/strings/str_cat.h>

#include <set>

#include "storage/record_rules.h"

namespace isthmus::storage {
namespace {

// Checks the pair of a match, or of a manual decision on one.
template <typename Record>
absl::Status CheckPair(const Record& match,
                       const std::function<bool(const SessionId&)>& has_session) {
  if (!(match.a < match.b) || !match.T_a_b.IsFinite()) {
    return absl::InvalidArgumentError(
        absl::StrCat("match ", match.a.value(), " ~ ", match.b.value(),
                     ": the pair must be ordered and its transform finite"));
  }
  for (const SessionId& session : {match.a, match.b}) {
    if (!has_session(session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("match with session ", session.value(), ", which does not exist"));
    }
  }
  return absl::OkStatus();
}

// A later segment is nothing without the session that the robot opened.
absl::Status CheckSession(const SessionRecord& record,
                          const std::function<bool(const SessionId&)>& has_session) {
  if (record.id.empty()) return absl::InvalidArgumentError("a session without an id");
  const bool is_later = record.segment > 1;
  if (record.segment == 0 || is_later == record.first_segment.empty() ||
      record.first_segment == record.id) {
    return absl::InvalidArgumentError(absl::StrCat("session ", record.id.value(),
                                                   ": segments count from 1, and those after the ",
                                                   "first, only those, name the first"));
  }
  if (!is_later || has_session(record.first_segment)) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("segment ", record.id.value(), " of session ",
                                                    record.first_segment.value(),
                                                    ", which does not exist"));
}

absl::Status CheckCheckpoint(const Checkpoint& checkpoint,
                             const std::function<bool(const SessionId&)>& has_session) {
  const std::string& session = checkpoint.session.value();
  if (!checkpoint.data || checkpoint.durable_sequence > checkpoint.sequence) {
    return absl::InvalidArgumentError(
        absl::StrCat("the checkpoint of session ", session,
                     " has no data, or more is durable than was dealt with"));
  }
  if (has_session(checkpoint.session)) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("a checkpoint of session ", session, ", which does not exist"));
}

// The records that came with placing submaps.
absl::Status CheckGraph(const WriteBatch& batch, const StoreContents& contents,
                        const std::function<bool(const SessionId&)>& has_session,
                        const std::set<SubmapId>& inserted) {
  for (const LoopClosure& loop : batch.loops) {
    if (absl::Status status = CheckLoop(loop); !status.ok()) return status;
    if (has_session(loop.session)) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "loop closure ", loop.id, " of session ", loop.session.value(), ", which does not exist"));
  }
  if (batch.datum && *batch.datum) {
    if (absl::Status status = CheckDatum(**batch.datum); !status.ok()) return status;
  }
  for (const Anchor& anchor : batch.anchors) {
    if (absl::Status status = CheckAnchor(anchor); !status.ok()) return status;
    if (inserted.count(anchor.submap) > 0 || contents.has_submap(anchor.submap)) continue;
    return absl::FailedPreconditionError(
        absl::StrCat("an anchor of submap ", ToString(anchor.submap), ", which does not exist"));
  }
  if (!batch.revision) {
    return batch.moves.empty() ? absl::OkStatus()
                               : absl::InvalidArgumentError("moves without a revision");
  }
  if (batch.revision->revision <= contents.latest_revision) {
    return absl::FailedPreconditionError(absl::StrCat("revision ", batch.revision->revision,
                                                      " is not newer than the latest, ",
                                                      contents.latest_revision));
  }
  return CheckRevision(*batch.revision, batch.moves);
}

}  // namespace

absl::Status CheckBatch(const WriteBatch& batch, const StoreContents& contents) {
  std::set<SessionId> inserted;
  const auto has_session = [&](const SessionId& id) {
    return inserted.count(id) > 0 || contents.has_session(id);
  };
  for (const SessionRecord& record : batch.sessions) {
    if (absl::Status status = CheckSession(record, has_session); !status.ok()) return status;
    inserted.insert(record.id);
  }
  const SessionId* last_known = nullptr;  // A batch mostly holds scans of one session.
  for (const auto& [session, entry] : batch.trajectory) {
    if (last_known != nullptr && *last_known == session) continue;
    if (!has_session(session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("a pose of session ", session.value(), ", which does not exist"));
    }
    last_known = &session;
  }
  for (const Checkpoint& checkpoint : batch.checkpoints) {
    if (absl::Status status = CheckCheckpoint(checkpoint, has_session); !status.ok()) return status;
  }
  for (const MatchingProgress& progress : batch.matching_progress) {
    if (has_session(progress.session)) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "matching progress of session ", progress.session.value(), ", which does not exist"));
  }
  std::set<SubmapId> submaps;
  for (const auto& submap : batch.submaps) {
    if (!has_session(submap->id.session)) {
      return absl::FailedPreconditionError(
          absl::StrCat("submap ", ToString(submap->id), " of a session that does not exist"));
    }
    if (!submaps.insert(submap->id).second || contents.has_submap(submap->id)) {
      return absl::AlreadyExistsError(
          absl::StrCat("submap ", ToString(submap->id), " is stored already"));
    }
    if (absl::Status status = CheckSubmap(*submap); !status.ok()) return status;
  }
  for (const Match& match : batch.matches) {
    if (absl::Status status = CheckPair(match, has_session); !status.ok()) return status;
    if (absl::Status status = CheckMatchEdges(match); !status.ok()) return status;
  }
  for (const ManualDecision& manual_decision : batch.manual_decisions) {
    if (absl::Status status = CheckPair(manual_decision, has_session); !status.ok()) return status;
  }
  if (absl::Status status = CheckEvents(batch.events); !status.ok()) return status;
  return CheckGraph(batch, contents, has_session, submaps);
}

absl::Status UnknownSession(const SessionId& session) {
  return absl::NotFoundError(absl::StrCat("there is no session '", session.value(), "'"));
}

absl::Status UnknownSubmap(const SubmapId& submap) {
  return absl::NotFoundError(absl::StrCat("there is no submap '", ToString(submap), "'"));
}

absl::Status NoCheckpoint(const SessionId& session) {
  return absl::NotFoundError(absl::StrCat("session '", session.value(), "' has no checkpoint"));
}

absl::Status NoFeatures(const SubmapId& submap, const std::string& kind) {
  return absl::NotFoundError(
      absl::StrCat("no features of kind '", kind, "' are kept for submap ", ToString(submap)));
}

}  // namespace isthmus::storage
