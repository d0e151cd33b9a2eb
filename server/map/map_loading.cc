// The map as the store has it at the start.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/map/map_writer.h"
#include "storage/batch_rules.h"

namespace isthmus::server {
namespace {

constexpr char kWhatToDo[] =
    "; `isthmus-server --check` says what else is damaged, and a backup has it as it was";

storage::StoreContents ContentsOf(const MapView& view) {
  return {[&view](const SessionId& session) { return view.Find(session) != nullptr; },
          [&view](const SubmapId& submap) {
            const SessionView* session = view.Find(submap.session);
            return session != nullptr && session->submaps.contains(submap.index);
          }};
}

// The sessions as no store takes them were damaged, and submaps and scans may be another's.
absl::Status CheckSessions(const std::vector<SessionRecord>& records) {
  storage::WriteBatch all;
  all.sessions = records;
  const absl::Status status = storage::CheckBatch(all, ContentsOf(MapView()));
  if (status.ok()) return status;
  return absl::DataLossError(absl::StrCat("the map is damaged: ", status.message(), kWhatToDo));
}

// The records that a store would take.
template <typename Record>
std::vector<Record> Sound(const std::vector<Record>& records,
                          std::vector<Record> storage::WriteBatch::*kind, const MapView& view,
                          const MapWriter::Note& note) {
  std::vector<Record> sound;
  for (const Record& record : records) {
    storage::WriteBatch one;
    one.*kind = {record};
    const absl::Status status = storage::CheckBatch(one, ContentsOf(view));
    if (status.ok()) {
      sound.push_back(record);
    } else if (note) {
      note(absl::StrCat("a damaged record is left out: ", status.message(), kWhatToDo));
    }
  }
  return sound;
}

}  // namespace

void MapWriter::MendPose(const Pose& instead, SubmapInfo* info) {
  if (info->T_odom_submap.IsFinite()) return;
  cache_->MarkDamaged(info->id,
                      absl::StrCat("submap ", ToString(info->id), ": its pose is not finite"));
  info->T_odom_submap = instead;
}

absl::Status MapWriter::LoadSessions(MapView* view) {
  absl::StatusOr<std::vector<SessionRecord>> records = store_->ListSessions();
  if (!records.ok()) return records.status();
  if (absl::Status status = CheckSessions(*records); !status.ok()) return status;
  for (const SessionRecord& record : *records) {
    absl::StatusOr<std::vector<SubmapInfo>> submaps = store_->ListSubmaps(record.id);
    if (!submaps.ok()) return submaps.status();
    storage::SubmapInfos infos;
    Pose last;  // Stands in for one that is damaged: its neighbours stay where they are.
    for (SubmapInfo& info : *submaps) {
      MendPose(last, &info);
      last = info.T_odom_submap;
      infos.push_back(std::make_shared<const SubmapInfo>(std::move(info)));
    }
    absl::StatusOr<std::vector<TrajectoryEntry>> trajectory = store_->GetTrajectory(record.id);
    if (!trajectory.ok()) return trajectory.status();
    storage::WriteBatch batch;
    batch.sessions.push_back(record);
    for (const TrajectoryEntry& entry : *trajectory)
      batch.trajectory.emplace_back(record.id, entry);
    storage::Apply(batch, infos, view);
  }
  return absl::OkStatus();
}

absl::Status MapWriter::LoadDecisions(const Note& note, MapView* view) {
  storage::WriteBatch batch;
  absl::StatusOr<std::vector<Match>> matches = store_->ListMatches();
  if (!matches.ok()) return matches.status();
  batch.matches = Sound(*matches, &storage::WriteBatch::matches, *view, note);
  absl::StatusOr<std::vector<ManualDecision>> manual_decisions = store_->ListManualDecisions();
  if (!manual_decisions.ok()) return manual_decisions.status();
  batch.manual_decisions =
      Sound(*manual_decisions, &storage::WriteBatch::manual_decisions, *view, note);
  absl::StatusOr<std::vector<Anchor>> anchors = store_->ListAnchors();
  if (!anchors.ok()) return anchors.status();
  batch.anchors = Sound(*anchors, &storage::WriteBatch::anchors, *view, note);
  absl::StatusOr<std::optional<Datum>> datum = store_->GetDatum();
  if (!datum.ok()) return datum.status();
  if (*datum) {
    const absl::Status status = CheckDatum(**datum);
    if (status.ok()) {
      batch.datum = *datum;
    } else if (note) {
      note(absl::StrCat("the datum is left out: ", status.message(), kWhatToDo));
    }
  }
  storage::Apply(batch, {}, view);
  return absl::OkStatus();
}

absl::Status MapWriter::LoadLoops(const Note& note, MapView* view) {
  storage::WriteBatch batch;
  absl::StatusOr<std::vector<LoopClosure>> loops = store_->ListLoops();
  if (!loops.ok()) return loops.status();
  batch.loops = Sound(*loops, &storage::WriteBatch::loops, *view, note);
  storage::Apply(batch, {}, view);
  uint64_t last = 0;
  for (const LoopClosure& loop : *loops) last = std::max(last, loop.id);
  absl::StatusOr<std::vector<RevisionInfo>> revisions =
      store_->ListRevisions(storage::kRevisionsKept);
  if (!revisions.ok()) return revisions.status();
  for (const RevisionInfo& info : *revisions) {
    for (const uint64_t id : info.loops) last = std::max(last, id);
  }
  MutexLock lock(&mutex_);
  next_loop_ = last + 1;
  return absl::OkStatus();
}

absl::Status MapWriter::Load(const Note& note) {
  MapView view;
  if (absl::Status status = LoadSessions(&view); !status.ok()) return status;
  if (absl::Status status = LoadDecisions(note, &view); !status.ok()) return status;
  if (absl::Status status = LoadLoops(note, &view); !status.ok()) return status;
  absl::StatusOr<MapRevision> latest = store_->LatestRevision();
  if (!latest.ok()) return latest.status();
  view.revision = std::make_shared<const MapRevision>(*std::move(latest));
  // Placed anew, and matches checked against each other, as nothing of that is stored.
  MapEdit restart;
  restart.changes.causes = {"restart"};
  PreparedEdit prepared;
  prepared.effective = EffectiveMatches(view);
  MutexLock lock(&mutex_);
  view_ = Apply(view, restart, prepared);
  changes_ = restart.changes;
  return absl::OkStatus();
}

}  // namespace isthmus::server
