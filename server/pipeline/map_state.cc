#include "server/pipeline/map_state.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "server/match_graph/cycles.h"
#include "server/match_graph/match_graph.h"
#include "server/match_graph/verdict.h"

namespace isthmus::server {
namespace {

uint64_t CountPoints(const std::vector<std::shared_ptr<const Submap>>& submaps) {
  uint64_t points = 0;
  for (const auto& submap : submaps) points += submap->points.size();
  return points;
}

// A robot with its own SLAM sends submaps; their keyframes come from no scan.
bool IsUploaded(const Submap& submap) { return submap.keyframes.front().sequence == 0; }

// The session has submaps.
match_graph::Node NodeOf(const SessionId& session, const SessionEntry& entry) {
  Box box;
  for (const auto& submap : entry.submaps) box.Extend(submap->T_odom_submap.translation());
  return {session, static_cast<double>(entry.points), (box.min + box.max) / 2,
          (box.max - box.min).norm()};
}

// Below this a change of a pose is rounding.
bool SamePose(const Pose& a, const Pose& b) {
  const Pose difference = a.Inverse() * b;
  return difference.translation().norm() < 1e-9 && RotationAngle(difference) < 1e-9;
}

bool SamePlacements(const std::vector<Placement>& a, const std::vector<Placement>& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].session != b[i].session || a[i].component != b[i].component ||
        a[i].reference != b[i].reference || !SamePose(a[i].T_map_odom, b[i].T_map_odom)) {
      return false;
    }
  }
  return true;
}

}  // namespace

absl::Status MapState::Load() {
  absl::StatusOr<std::vector<SessionRecord>> records = store_->ListSessions();
  if (!records.ok()) return records.status();
  for (const SessionRecord& record : *records) {
    SessionEntry& entry = sessions[record.id];
    entry.record = record;
    absl::StatusOr<std::vector<SubmapInfo>> infos = store_->ListSubmaps(record.id);
    if (!infos.ok()) return infos.status();
    for (const SubmapInfo& info : *infos) {
      absl::StatusOr<std::shared_ptr<const Submap>> submap = store_->GetSubmap(info.id);
      if (!submap.ok()) return submap.status();
      entry.submaps.push_back(*std::move(submap));
    }
    entry.points = CountPoints(entry.submaps);
    entry.uploads = !entry.submaps.empty() && IsUploaded(*entry.submaps.front());
    absl::StatusOr<std::vector<TrajectoryEntry>> trajectory = store_->GetTrajectory(record.id);
    if (!trajectory.ok()) return trajectory.status();
    entry.trajectory = *std::move(trajectory);
  }
  absl::StatusOr<std::vector<Match>> stored = store_->ListMatches();
  if (!stored.ok()) return stored.status();
  for (Match& match : *stored) {
    SessionPair pair(match.a, match.b);
    matches[std::move(pair)] = std::move(match);
  }
  absl::StatusOr<std::vector<Verdict>> said = store_->ListVerdicts();
  if (!said.ok()) return said.status();
  for (Verdict& verdict : *said) {
    SessionPair pair(verdict.a, verdict.b);
    verdicts[std::move(pair)] = std::move(verdict);
  }
  absl::StatusOr<MapRevision> latest = store_->LatestRevision();
  if (!latest.ok()) return latest.status();
  revision = *std::move(latest);
  return Replace("restart");
}

SessionEntry* MapState::Find(const SessionId& session) {
  const auto it = sessions.find(session);
  return it == sessions.end() ? nullptr : &it->second;
}

SessionEntry* MapState::Newest(const RobotId& robot) {
  SessionEntry* newest = nullptr;
  for (auto& [id, entry] : sessions) {
    if (entry.record.robot != robot) continue;
    if (newest == nullptr || entry.record.created_ns >= newest->record.created_ns) newest = &entry;
  }
  return newest;
}

const Placement* MapState::PlacementOf(const SessionId& session) const {
  for (const Placement& placement : revision.placements) {
    if (placement.session == session) return &placement;
  }
  return nullptr;
}

std::optional<Match> MapState::EffectiveMatch(const SessionPair& pair) const {
  const auto it = std::lower_bound(effective_.begin(), effective_.end(), pair,
                                   [](const Match& match, const SessionPair& wanted) {
                                     return SessionPair(match.a, match.b) < wanted;
                                   });
  if (it == effective_.end() || SessionPair(it->a, it->b) != pair) return std::nullopt;
  return *it;
}

std::vector<Match> MapState::Combine(const std::vector<match_graph::Node>& nodes) const {
  std::map<SessionPair, Match> combined = matches;
  for (const auto& [pair, verdict] : verdicts) {
    const auto computed = matches.find(pair);
    combined[pair] = match_graph::Apply(
        verdict, computed == matches.end() ? std::nullopt : std::make_optional(computed->second));
  }
  std::vector<Match> effective;
  for (auto& [pair, match] : combined) effective.push_back(std::move(match));
  match_graph::CheckCycles(nodes, match_graph::CycleOptions(), &effective);
  return effective;
}

std::vector<PlacedSubmap> MapState::PlacedSubmaps() const {
  std::vector<PlacedSubmap> placed;
  for (const Placement& placement : revision.placements) {
    const auto it = sessions.find(placement.session);
    if (it == sessions.end()) continue;
    for (const auto& submap : it->second.submaps) {
      placed.push_back({submap, placement.component, placement.T_map_odom});
    }
  }
  return placed;
}

absl::Status MapState::AddStretch(const SessionId& session, const ingest::Stretch& stretch) {
  storage::WriteBatch batch;
  batch.submaps.push_back(stretch.submap);
  for (const TrajectoryEntry& entry : stretch.trajectory) {
    batch.trajectory.emplace_back(session, entry);
  }
  // Outside the lock: the disk may take its time, and one session writes one stretch at a time.
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  SessionEntry* entry = Find(session);
  if (entry == nullptr) {
    return absl::NotFoundError(absl::StrCat("session ", session.value(), " was deleted"));
  }
  entry->submaps.push_back(stretch.submap);
  entry->points += stretch.submap->points.size();
  entry->trajectory.insert(entry->trajectory.end(), stretch.trajectory.begin(),
                           stretch.trajectory.end());
  ++submap_version;
  absl::Status status = absl::OkStatus();
  if (PlacementOf(session) == nullptr) {
    status = Replace(absl::StrCat("first submap of ", session.value()));
  }
  changed.notify_all();
  return status;
}

absl::Status MapState::PutMatch(const Match& match) {
  {
    std::lock_guard lock(mutex);
    if (Find(match.a) == nullptr || Find(match.b) == nullptr) return absl::OkStatus();
  }
  storage::WriteBatch batch;
  batch.matches.push_back(match);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  if (Find(match.a) == nullptr || Find(match.b) == nullptr) return absl::OkStatus();
  matches[{match.a, match.b}] = match;
  absl::Status status = Replace(
      absl::StrCat("match ", match.a.value(), " ~ ", match.b.value(), " ", ToString(match.state)));
  changed.notify_all();
  return status;
}

absl::Status MapState::PutVerdict(const Verdict& verdict) {
  storage::WriteBatch batch;
  batch.verdicts.push_back(verdict);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  verdicts[{verdict.a, verdict.b}] = verdict;
  absl::Status status = Replace(absl::StrCat("match ", verdict.a.value(), " ~ ", verdict.b.value(),
                                             " by hand: ", ToString(verdict.ruling)));
  changed.notify_all();
  return status;
}

absl::Status MapState::WithdrawVerdict(const SessionId& a, const SessionId& b) {
  storage::WriteBatch batch;
  batch.withdrawn_verdicts.emplace_back(a, b);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  std::lock_guard lock(mutex);
  verdicts.erase({a, b});
  absl::Status status =
      Replace(absl::StrCat("match ", a.value(), " ~ ", b.value(), ": word by hand withdrawn"));
  changed.notify_all();
  return status;
}

absl::Status MapState::RemoveSession(const SessionId& session) {
  if (absl::Status status = store_->DeleteSession(session); !status.ok()) return status;
  std::lock_guard lock(mutex);
  sessions.erase(session);
  const auto of_session = [&](const auto& item) {
    return item.first.first == session || item.first.second == session;
  };
  std::erase_if(matches, of_session);
  std::erase_if(verdicts, of_session);
  ++submap_version;
  absl::Status status = Replace(absl::StrCat("session ", session.value(), " deleted"));
  changed.notify_all();
  return status;
}

void MapState::ScanQueued() {
  std::lock_guard lock(mutex);
  ++pending_scans;
}

void MapState::ScanDone() {
  std::lock_guard lock(mutex);
  --pending_scans;
  changed.notify_all();
}

absl::Status MapState::Replace(const std::string& cause) {
  std::vector<match_graph::Node> nodes;
  for (const auto& [id, entry] : sessions) {
    if (!entry.submaps.empty()) nodes.push_back(NodeOf(id, entry));
  }
  effective_ = Combine(nodes);
  const match_graph::Solution solution = match_graph::Solve(nodes, effective_, revision.placements);
  tree.clear();
  for (size_t edge : solution.tree) tree.emplace_back(effective_[edge].a, effective_[edge].b);
  if (SamePlacements(solution.placements, revision.placements)) return absl::OkStatus();
  MapRevision next;
  next.revision = revision.revision + 1;
  next.stamp_ns = clock_->NowNs();
  next.cause = cause;
  next.placements = solution.placements;
  storage::WriteBatch batch;
  batch.revision = next;
  absl::Status status = store_->Write(batch);
  // Readers see the newest truth even when it could not be stored: it follows from the stored
  // matches and is found again at the next start.
  revision = std::move(next);
  return status;
}

}  // namespace isthmus::server
