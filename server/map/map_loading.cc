// The map as the store has it at the start.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/map/map_writer.h"

namespace isthmus::server {

void MapWriter::MendPose(const Pose& instead, SubmapInfo* info) {
  if (info->T_odom_submap.IsFinite()) return;
  cache_->MarkDamaged(info->id,
                      absl::StrCat("submap ", ToString(info->id), ": its pose is not finite"));
  info->T_odom_submap = instead;
}

absl::Status MapWriter::LoadSessions(MapView* view) {
  absl::StatusOr<std::vector<SessionRecord>> records = store_->ListSessions();
  if (!records.ok()) return records.status();
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

absl::Status MapWriter::LoadDecisions(MapView* view) {
  storage::WriteBatch batch;
  absl::StatusOr<std::vector<Match>> matches = store_->ListMatches();
  if (!matches.ok()) return matches.status();
  batch.matches = *std::move(matches);
  absl::StatusOr<std::vector<ManualDecision>> manual_decisions = store_->ListManualDecisions();
  if (!manual_decisions.ok()) return manual_decisions.status();
  batch.manual_decisions = *std::move(manual_decisions);
  absl::StatusOr<std::vector<Anchor>> anchors = store_->ListAnchors();
  if (!anchors.ok()) return anchors.status();
  batch.anchors = *std::move(anchors);
  absl::StatusOr<std::optional<Datum>> datum = store_->GetDatum();
  if (!datum.ok()) return datum.status();
  batch.datum = *datum;
  storage::Apply(batch, {}, view);
  return absl::OkStatus();
}

absl::Status MapWriter::LoadLoops(MapView* view) {
  storage::WriteBatch batch;
  absl::StatusOr<std::vector<LoopClosure>> loops = store_->ListLoops();
  if (!loops.ok()) return loops.status();
  batch.loops = *std::move(loops);
  storage::Apply(batch, {}, view);
  uint64_t last = 0;
  for (const LoopClosure& loop : batch.loops) last = std::max(last, loop.id);
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

absl::Status MapWriter::Load() {
  MapView view;
  if (absl::Status status = LoadSessions(&view); !status.ok()) return status;
  if (absl::Status status = LoadDecisions(&view); !status.ok()) return status;
  if (absl::Status status = LoadLoops(&view); !status.ok()) return status;
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
