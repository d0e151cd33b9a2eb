// The edits of the map, one by one.
#include <absl/strings/str_cat.h>

#include <set>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/map/edit_events.h"
#include "server/map/map_writer.h"

namespace isthmus::server {
namespace {

std::string NameOf(const SessionId& a, const SessionId& b) {
  return absl::StrCat("match ", a.value(), " ~ ", b.value());
}

}  // namespace

absl::Status MapWriter::PutSessions(const std::vector<SessionRecord>& sessions,
                                    std::optional<Event> event) {
  MapEdit edit;
  edit.batch.sessions = sessions;
  if (event) edit.batch.events = Stamped({*std::move(event)});
  return CommitEdit(edit);
}

std::vector<SessionRecord> MapWriter::NewSegments(const SessionId& session,
                                                  const FinishedSubmap& finished) const {
  std::set<uint32_t> numbers;
  if (finished.submap != nullptr) numbers.insert(finished.segment);
  if (finished.checkpoint) numbers.insert(finished.checkpoint->segment);
  std::vector<SessionRecord> records;
  const View now = view();
  const SessionView* opened = now->Find(session);
  for (const uint32_t number : numbers) {
    const SessionId id = SegmentId(session, number);
    if (opened == nullptr || now->Find(id) != nullptr) continue;
    SessionRecord& record = records.emplace_back(opened->record);
    record.id = id;
    record.segment = number;
    record.first_segment = session;
    record.request_id.clear();
    record.created_ns = clock_->NowNs();
  }
  return records;
}

bool MapWriter::IsWritten(const std::shared_ptr<const Submap>& submap) const {
  if (submap == nullptr) return false;
  const View now = view();
  const SessionView* session = now->Find(submap->id.session);
  if (session != nullptr && session->submaps.contains(submap->id.index)) return false;
  const auto stored = store_->GetSubmap(submap->id);
  return stored.ok() && (*stored)->first_stamp_ns == submap->first_stamp_ns &&
         (*stored)->last_sequence == submap->last_sequence &&
         (*stored)->points.size() == submap->points.size();
}

absl::Status MapWriter::AddSubmap(const SessionId& session, const FinishedSubmap& finished) {
  const SessionId segment = SegmentId(session, finished.segment);
  MapEdit edit;
  edit.rests_on = {session};
  edit.batch.sessions = NewSegments(session, finished);
  if (finished.submap != nullptr) {
    edit.batch.submaps.push_back(finished.submap);
    edit.changes.causes = {absl::StrCat("submap ", ToString(finished.submap->id))};
  }
  if (const auto& checkpoint = finished.checkpoint) {
    edit.batch.checkpoints.push_back(
        {session, checkpoint->sequence, checkpoint->durable_sequence, checkpoint->state});
  }
  for (const TrajectoryEntry& entry : finished.trajectory) {
    edit.batch.trajectory.emplace_back(segment, entry);
  }
  // Without a lock: the disk may take its time, and one session writes one submap at a time.
  absl::Status status = store_->Write(edit.batch);
  if (!status.ok() && !(absl::IsAlreadyExists(status) && IsWritten(finished.submap))) return status;
  if (finished.submap == nullptr && edit.batch.sessions.empty()) {
    // Nothing that a view shows.
    if (!IsVoid(edit, *view())) return absl::OkStatus();
  } else {
    if (finished.submap != nullptr) cache_->Put(finished.submap);
    if (ShowEdit(edit)) return absl::OkStatus();
    if (finished.submap != nullptr) cache_->Forget(finished.submap->id);
  }
  return absl::NotFoundError(absl::StrCat("session ", session.value(), " was deleted"));
}

absl::Status MapWriter::PutMatch(const Match& match) {
  MapEdit edit;
  edit.rests_on = {match.a, match.b};
  if (IsVoid(edit, *view())) return absl::OkStatus();
  edit.batch.matches = {match};
  edit.changes.causes = {absl::StrCat(NameOf(match.a, match.b), " ", ToString(match.state))};
  edit.changes.matches = {{match.a, match.b}};
  return CommitEdit(edit);
}

absl::Status MapWriter::PutDecisions(const ManualEdit& decisions) {
  MapEdit edit;
  edit.batch.manual_decisions = decisions.manual_decisions;
  edit.batch.withdrawn_decisions = decisions.withdrawn;
  edit.batch.loops = decisions.loops;
  edit.batch.events = Stamped(DecisionEvents(decisions, *view()));
  Changes& changes = edit.changes;
  for (const ManualDecision& manual_decision : decisions.manual_decisions) {
    changes.matches.emplace_back(manual_decision.a, manual_decision.b);
    changes.causes.push_back(absl::StrCat(NameOf(manual_decision.a, manual_decision.b),
                                          " by hand: ", ToString(manual_decision.kind)));
  }
  for (const SessionPair& pair : decisions.withdrawn) {
    changes.matches.push_back(pair);
    changes.causes.push_back(
        absl::StrCat(NameOf(pair.first, pair.second), ": decision by hand withdrawn"));
  }
  for (const LoopClosure& loop : decisions.loops) {
    changes.loops.push_back(loop.id);
    changes.causes.push_back(
        absl::StrCat("loop ", loop.id, " by hand: ", loop.rejected ? "REJECT" : "RESTORE"));
  }
  return CommitEdit(edit);
}

absl::Status MapWriter::AddLoops(std::vector<LoopClosure> found) {
  const View now = view();
  std::erase_if(found, [&](const LoopClosure& loop) { return now->Find(loop.session) == nullptr; });
  if (found.empty()) return absl::OkStatus();
  MapEdit edit;
  const int64_t now_ns = clock_->NowNs();
  for (LoopClosure& loop : found) {
    {
      MutexLock lock(&mutex_);
      loop.id = next_loop_++;
    }
    loop.computed_ns = now_ns;
    edit.rests_on.push_back(loop.session);
    edit.changes.loops.push_back(loop.id);
    edit.changes.causes.push_back(absl::StrCat("loop ", loop.id, ": ",
                                               ToString(SubmapId{loop.session, loop.submap_b}),
                                               " on ", loop.submap_a));
  }
  edit.batch.events = Stamped(LoopEvents(found, *now));
  edit.batch.loops = std::move(found);
  return CommitEdit(edit);
}

absl::Status MapWriter::PutAnchor(const Anchor& anchor, const Actor& by) {
  MapEdit edit;
  edit.batch.events =
      Stamped({AnchorEvent(EventKind::kAnchorSet, anchor.submap, by, anchor.note, *view())});
  edit.batch.anchors = {anchor};
  edit.changes.causes = {absl::StrCat("anchor of ", ToString(anchor.submap))};
  return CommitEdit(edit);
}

absl::Status MapWriter::RemoveAnchor(const SubmapId& submap, const Actor& by) {
  MapEdit edit;
  edit.batch.events = Stamped({AnchorEvent(EventKind::kAnchorRemoved, submap, by, "", *view())});
  edit.batch.removed_anchors = {submap};
  edit.changes.causes = {absl::StrCat("anchor of ", ToString(submap), " removed")};
  return CommitEdit(edit);
}

absl::Status MapWriter::SetDatum(const std::optional<Datum>& datum, const Actor& by) {
  MapEdit edit;
  edit.batch.events = Stamped({DatumEvent(datum, by)});
  edit.batch.datum = datum;
  return CommitEdit(edit);
}

absl::Status MapWriter::RetireSubmaps(const std::vector<SubmapId>& submaps) {
  if (submaps.empty()) return absl::OkStatus();
  const std::set<SubmapId> gone(submaps.begin(), submaps.end());
  MapEdit edit;
  edit.batch.retired = submaps;
  edit.changes.causes = {
      absl::StrCat(gone.size(), " submaps retired, ", ToString(*gone.begin()), " first")};
  if (absl::Status status = CommitEdit(edit); !status.ok()) return status;
  for (const SubmapId& id : gone) cache_->Forget(id);
  activity_->ForgetDamage([&](const SubmapId& id) { return gone.contains(id); });
  return absl::OkStatus();
}

absl::Status MapWriter::RemoveSession(const SessionId& session, const std::string& why,
                                      const Actor& by) {
  const View before = view();
  std::vector<Event> events;
  if (const SessionView* known = before->Find(session)) {
    const EventKind kind = why.empty() ? EventKind::kSessionDeleted : EventKind::kSessionExpired;
    events = Stamped({SessionEvent(kind, known->record, by, why)});
  }
  if (auto status = store_->DeleteSession(session, events); !status.ok()) return status;
  MapEdit edit;
  edit.removed_session = session;
  edit.changes.causes = {
      absl::StrCat("session ", session.value(), " deleted", why.empty() ? "" : ": ", why)};
  (void)ShowEdit(edit);
  const View after = view();
  for (const SessionView* segment : before->SegmentsOf(session)) {
    for (const auto& [index, submap] : segment->submaps) cache_->Forget(submap.id);
  }
  activity_->ForgetDamage([&](const SubmapId& id) { return after->Find(id.session) == nullptr; });
  return absl::OkStatus();
}

}  // namespace isthmus::server
