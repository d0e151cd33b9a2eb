#include "server/pipeline/map_state.h"

#include <algorithm>
#include <utility>

#include "server/match_graph/cycles.h"
#include "server/match_graph/verdict.h"

namespace isthmus::server {
namespace {

// A robot with its own SLAM sends submaps; their keyframes come from no scan.
bool HasUploads(const SessionEntry& entry, SubmapCache* cache) {
  for (const auto& submap : entry.submaps) {
    const std::shared_ptr<const Submap> outline = cache->Outline(submap->id);
    if (outline) return outline->keyframes.front().sequence == 0;
  }
  return false;
}

placement::Session PlacementSession(const SessionId& id, const SessionEntry& entry) {
  placement::Session session;
  session.tree.session = id;
  double total = 0;
  for (const auto& [index, way] : entry.way_m) total += way;
  const double mean = entry.way_m.empty() ? 0 : total / static_cast<double>(entry.way_m.size());
  const SubmapInfo* before = nullptr;
  for (const auto& submap : entry.submaps) {
    placement::Node node;
    node.index = submap->id.index;
    node.T_odom_submap = submap->T_odom_submap;
    if (before != nullptr) {
      // What a retired submap knew of the way went with it.
      const auto way = entry.way_m.find(submap->id.index - 1);
      node.travelled_m = way == entry.way_m.end() ? mean : way->second;
      if (before->id.index + 1 == submap->id.index) {
        node.drift_covariance = submap->drift_covariance;
      }
    }
    session.nodes.push_back(node);
    before = submap.get();
  }
  return session;
}

}  // namespace

std::shared_ptr<const SubmapInfo> SessionEntry::FindSubmap(uint32_t index) const {
  const auto it = std::lower_bound(
      submaps.begin(), submaps.end(), index,
      [](const auto& submap, uint32_t wanted) { return submap->id.index < wanted; });
  return it == submaps.end() || (*it)->id.index != index ? nullptr : *it;
}

// The step to the first scan of a submap belongs to the one before.
void SessionEntry::AddPose(const TrajectoryEntry& pose) {
  // Where a submap between the two was retired this is no way that was gone.
  if (last_pose && pose.submap_index <= last_pose->submap_index + 1) {
    way_m[last_pose->submap_index] +=
        (pose.T_odom_sensor.translation() - last_pose->T_odom_sensor.translation()).norm();
  }
  last_pose = pose;
}

std::vector<match_graph::Node> MapState::MatchGraphNodes() const {
  std::vector<match_graph::Node> nodes;
  for (const auto& [id, entry] : sessions) {
    if (entry.submaps.empty()) continue;
    Box box;
    for (const auto& submap : entry.submaps) box.Extend(submap->T_odom_submap.translation());
    nodes.push_back({id, static_cast<double>(entry.points), (box.min + box.max) / 2,
                     (box.max - box.min).norm()});
  }
  return nodes;
}

absl::Status MapState::LoadSession(const SessionRecord& record) {
  SessionEntry& entry = sessions[record.id];
  entry.record = record;
  absl::StatusOr<std::vector<SubmapInfo>> infos = store_->ListSubmaps(record.id);
  if (!infos.ok()) return infos.status();
  for (SubmapInfo& info : *infos) {
    entry.points += info.point_count;
    entry.submaps.push_back(std::make_shared<const SubmapInfo>(std::move(info)));
  }
  // A finished session takes neither scans nor submaps.
  entry.uploads =
      record.state == SessionState::kActive && record.segment == 1 && HasUploads(entry, cache_);
  absl::StatusOr<std::vector<TrajectoryEntry>> trajectory = store_->GetTrajectory(record.id);
  if (!trajectory.ok()) return trajectory.status();
  for (const TrajectoryEntry& pose : *trajectory) entry.AddPose(pose);
  return absl::OkStatus();
}

absl::Status MapState::Load() {
  absl::StatusOr<std::vector<SessionRecord>> records = store_->ListSessions();
  if (!records.ok()) return records.status();
  for (const SessionRecord& record : *records) {
    if (absl::Status status = LoadSession(record); !status.ok()) return status;
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
  if (absl::Status status = LoadLoops(); !status.ok()) return status;
  absl::StatusOr<std::vector<Anchor>> given = store_->ListAnchors();
  if (!given.ok()) return given.status();
  for (Anchor& anchor : *given) anchors[anchor.submap] = std::move(anchor);
  absl::StatusOr<MapRevision> latest = store_->LatestRevision();
  if (!latest.ok()) return latest.status();
  revision = *std::move(latest);
  RefreshMatches();
  Changed("restart");
  return absl::OkStatus();
}

absl::Status MapState::LoadLoops() {
  absl::StatusOr<std::vector<LoopClosure>> closed = store_->ListLoops();
  if (!closed.ok()) return closed.status();
  for (LoopClosure& loop : *closed) {
    const uint64_t id = loop.id;
    next_loop_ = std::max(next_loop_, id + 1);
    loops[id] = std::move(loop);
  }
  absl::StatusOr<std::vector<RevisionInfo>> revisions =
      store_->ListRevisions(storage::kRevisionsKept);
  if (!revisions.ok()) return revisions.status();
  for (const RevisionInfo& info : *revisions) {
    for (const uint64_t id : info.loops) next_loop_ = std::max(next_loop_, id + 1);
  }
  return absl::OkStatus();
}

SessionEntry* MapState::Find(const SessionId& session) {
  const auto it = sessions.find(session);
  return it == sessions.end() ? nullptr : &it->second;
}

SessionEntry* MapState::Newest(const RobotId& robot) {
  SessionEntry* newest = nullptr;
  for (auto& [id, entry] : sessions) {
    if (entry.record.robot != robot || entry.record.segment > 1) continue;
    if (newest == nullptr || entry.record.created_ns >= newest->record.created_ns) newest = &entry;
  }
  return newest == nullptr ? nullptr : SegmentsOf(newest->record.id).back();
}

std::vector<const SessionEntry*> MapState::SegmentsOf(const SessionId& opened) const {
  std::vector<const SessionEntry*> segments;
  for (const auto& [id, entry] : sessions) {
    if (entry.record.opened() == opened) segments.push_back(&entry);
  }
  std::sort(segments.begin(), segments.end(),
            [](const auto* a, const auto* b) { return a->record.segment < b->record.segment; });
  return segments;
}

std::vector<SessionEntry*> MapState::SegmentsOf(const SessionId& opened) {
  std::vector<SessionEntry*> segments;
  for (const SessionEntry* entry : std::as_const(*this).SegmentsOf(opened)) {
    segments.push_back(Find(entry->record.id));
  }
  return segments;
}

const Placement* MapState::PlacementOf(const SessionId& session) const {
  const auto it = std::lower_bound(
      revision.placements.begin(), revision.placements.end(), session,
      [](const Placement& placement, const SessionId& id) { return placement.session < id; });
  return it == revision.placements.end() || it->session != session ? nullptr : &*it;
}

std::optional<Match> MapState::EffectiveMatch(const SessionPair& pair) const {
  const auto it = std::lower_bound(effective_.begin(), effective_.end(), pair,
                                   [](const Match& match, const SessionPair& wanted) {
                                     return SessionPair(match.a, match.b) < wanted;
                                   });
  if (it == effective_.end() || SessionPair(it->a, it->b) != pair) return std::nullopt;
  return *it;
}

void MapState::RefreshMatches() {
  std::map<SessionPair, Match> combined = matches;
  for (const auto& [pair, verdict] : verdicts) {
    const auto computed = matches.find(pair);
    combined[pair] = match_graph::Apply(
        verdict, computed == matches.end() ? std::nullopt : std::make_optional(computed->second));
  }
  effective_.clear();
  for (auto& [pair, match] : combined) effective_.push_back(std::move(match));
  match_graph::CheckCycles(MatchGraphNodes(), match_graph::CycleOptions(), &effective_);
}

std::vector<PlacedSubmap> MapState::PlacedSubmaps() const {
  std::vector<PlacedSubmap> placed;
  for (const Placement& placement : revision.placements) {
    const auto it = sessions.find(placement.session);
    if (it == sessions.end()) continue;
    for (const SubmapPose& pose : placement.submaps) {
      if (std::shared_ptr<const SubmapInfo> submap = it->second.FindSubmap(pose.index)) {
        placed.push_back({std::move(submap), placement.component, pose.T_map_submap});
      }
    }
  }
  return placed;
}

placement::Input MapState::PlacementInput() const {
  placement::Input input;
  for (const auto& [id, entry] : sessions) {
    if (!entry.submaps.empty()) input.sessions.push_back(PlacementSession(id, entry));
  }
  input.matches = effective_;
  for (const auto& [id, loop] : loops) input.loops.push_back(loop);
  for (const auto& [submap, anchor] : anchors) input.anchors.push_back(anchor);
  return input;
}

void MapState::WaitUntilPlaced() {
  std::unique_lock lock(mutex);
  const uint64_t wanted = graph_version;
  changed.wait(lock, [&] { return placed_version >= wanted || !placing; });
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

}  // namespace isthmus::server
