// What readers ask of the map.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <set>

#include "server/match_graph/match_graph.h"
#include "server/pipeline/pipeline_impl.h"
#include "server/placement/corrected_trajectory.h"
#include "server/query/export.h"

namespace isthmus::server {
namespace {

absl::Status UnknownRobot(const RobotId& robot) {
  return absl::NotFoundError(
      absl::StrCat("no robot \"", robot.value(), "\" has opened a session on this server"));
}

query::CloudFormat CloudFormatOf(ExportFormat format) {
  switch (format) {
    case ExportFormat::kPcdAscii:
      return query::CloudFormat::kPcdAscii;
    case ExportFormat::kPcdBinaryCompressed:
      return query::CloudFormat::kPcdBinaryCompressed;
    case ExportFormat::kPly:
      return query::CloudFormat::kPly;
    default:
      return query::CloudFormat::kPcdBinary;
  }
}

// Null where it is not placed.
const SubmapPose* FindPose(const Placement* placement, uint32_t index) {
  if (placement == nullptr) return nullptr;
  const auto it =
      std::lower_bound(placement->submaps.begin(), placement->submaps.end(), index,
                       [](const SubmapPose& pose, uint32_t wanted) { return pose.index < wanted; });
  return it == placement->submaps.end() || it->index != index ? nullptr : &*it;
}

// Those that are not there yet; both in order of sequence.
void Append(const std::vector<TrajectoryEntry>& newer, std::vector<TrajectoryEntry>* entries) {
  const uint64_t last = entries->empty() ? 0 : entries->back().sequence;
  for (const TrajectoryEntry& entry : newer) {
    if (entry.sequence > last) entries->push_back(entry);
  }
}

std::vector<placement::TrajectoryKnot> KnotsOf(
    const std::vector<std::shared_ptr<const SubmapInfo>>& submaps,
    const std::vector<TrajectoryEntry>& entries) {
  std::map<uint32_t, int64_t> first_stamps;  // A submap's first scan is its first keyframe.
  for (const TrajectoryEntry& entry : entries) {
    first_stamps.try_emplace(entry.submap_index, entry.stamp_ns);
  }
  std::vector<placement::TrajectoryKnot> knots;
  for (const auto& submap : submaps) {
    const auto it = first_stamps.find(submap->id.index);
    const int64_t stamp_ns = it == first_stamps.end() ? submap->first_stamp_ns : it->second;
    knots.push_back({submap->id.index, stamp_ns, submap->T_odom_submap});
  }
  return knots;
}

// What a trajectory of one segment is made of, all as of one moment.
struct SegmentView {
  uint32_t segment = 1;
  SessionId session;
  std::vector<std::shared_ptr<const SubmapInfo>> submaps;
  std::vector<TrajectoryEntry> unsaved;
  std::optional<Placement> placement;
};

// The state's mutex is held.
std::vector<SegmentView> ViewSegments(const MapState& state, const SessionId& opened) {
  std::vector<SegmentView> views;
  std::map<uint32_t, std::vector<TrajectoryEntry>> unsaved;
  for (const SessionEntry* entry : state.SegmentsOf(opened)) {
    SegmentView& view = views.emplace_back();
    view.segment = entry->record.segment;
    view.session = entry->record.id;
    view.submaps = entry->submaps;
    // Before the store is asked: what leaves these meanwhile is in the store by then.
    if (entry->worker != nullptr) unsaved = entry->worker->Status().unsaved;
    view.unsaved = unsaved[view.segment];
    if (const Placement* placed = state.PlacementOf(view.session)) view.placement = *placed;
  }
  return views;
}

// Those that the answer has poses of, which share its frame; the others are noted as left out.
std::vector<SegmentView> ChooseSegments(TrajectoryFrame frame, uint32_t wanted,
                                        std::vector<SegmentView> segments,
                                        RobotTrajectory* trajectory) {
  const uint32_t last = segments.back().segment;
  std::optional<uint32_t> component;
  for (const SegmentView& view : segments) {
    if (!view.placement || (wanted > 0 && view.segment != wanted)) continue;
    component = std::min(component.value_or(view.placement->component), view.placement->component);
  }
  if (frame == TrajectoryFrame::kMap) trajectory->component = component.value_or(0);
  const auto is_chosen = [&](const SegmentView& view) {
    if (wanted > 0 && view.segment != wanted) return false;
    if (frame == TrajectoryFrame::kOdom) return wanted > 0 || view.segment == last;
    return view.placement && view.placement->component == component;
  };
  std::vector<SegmentView> chosen;
  for (SegmentView& view : segments) {
    if (is_chosen(view)) {
      chosen.push_back(std::move(view));
    } else {
      trajectory->left_out.push_back(view.segment);
    }
  }
  return chosen;
}

Trajectory OdomPoses(const std::vector<TrajectoryEntry>& entries) {
  Trajectory poses;
  for (const TrajectoryEntry& entry : entries) {
    poses.push_back({entry.stamp_ns, entry.T_odom_sensor});
  }
  return poses;
}

// Bytes handed to a sink at a time.
constexpr size_t kFileChunk = 1 << 20;

}  // namespace

MapInfo PipelineImpl::GetMapInfo() {
  std::lock_guard lock(state_.mutex);
  MapInfo info;
  info.revision = state_.revision.revision;
  info.settled = IsSettled();
  info.composition_ms = state_.composition_ms;
  info.composition_max_ms = state_.composition_max_ms;
  info.estimation_ms = state_.estimation_ms;
  info.compositions = state_.compositions;
  info.placement_ms = state_.placement_ms;
  info.estimations = state_.estimations;
  info.placements = state_.placements;
  info.retired = state_.retired;
  info.storage_problem = health_.Problem();
  for (const auto& [id, problem] : state_.damaged) info.damaged.push_back(problem);
  std::set<RobotId> robots;
  for (const auto& [id, entry] : state_.sessions) robots.insert(entry.record.robot);
  info.robots.assign(robots.begin(), robots.end());
  for (const Placement& placement : state_.revision.placements) {
    if (info.components.size() <= placement.component) {
      info.components.resize(placement.component + 1);
    }
    ComponentInfo& component = info.components[placement.component];
    component.component = placement.component;
    component.reference = placement.reference;
    component.sessions.push_back(placement.session);
    info.submaps += placement.submaps.size();
  }
  // Between a new revision and its composition the older map is served, and described.
  for (ComponentInfo& component : info.components) {
    component.point_count = state_.map->point_count(component.component);
    component.bounds = state_.map->bounds(component.component);
  }
  return info;
}

absl::StatusOr<std::vector<SubmapStatus>> PipelineImpl::ListSubmaps(
    const std::optional<RobotId>& robot) {
  std::vector<SubmapStatus> list;
  std::lock_guard lock(state_.mutex);
  if (robot && state_.Newest(*robot) == nullptr) return UnknownRobot(*robot);
  for (const auto& [id, entry] : state_.sessions) {
    if (robot && entry.record.robot != *robot) continue;
    absl::StatusOr<std::vector<SubmapInfo>> infos = store_->ListSubmaps(id);
    if (absl::IsNotFound(infos.status())) continue;  // Is being deleted.
    if (!infos.ok()) return infos.status();
    const Placement* placement = state_.PlacementOf(id);
    for (SubmapInfo& info : *infos) {
      SubmapStatus& status = list.emplace_back();
      if (const SubmapPose* pose = FindPose(placement, info.id.index)) {
        status.component = placement->component;
        status.T_map_submap = pose->T_map_submap;
      }
      status.info = std::move(info);
    }
  }
  return list;
}

absl::StatusOr<RobotTrajectory> PipelineImpl::GetTrajectory(const RobotId& robot,
                                                            TrajectoryFrame frame,
                                                            uint32_t segment) {
  RobotTrajectory trajectory;
  std::vector<SegmentView> segments;
  {
    std::lock_guard lock(state_.mutex);
    const SessionEntry* newest = state_.Newest(robot);
    if (newest == nullptr) return UnknownRobot(robot);
    trajectory.session = newest->record.opened();
    trajectory.revision = state_.revision.revision;
    segments = ViewSegments(state_, trajectory.session);
  }
  for (SegmentView& view : ChooseSegments(frame, segment, std::move(segments), &trajectory)) {
    absl::StatusOr<std::vector<TrajectoryEntry>> entries = store_->GetTrajectory(view.session);
    if (!entries.ok()) return entries.status();
    Append(view.unsaved, &*entries);
    const Trajectory poses = frame == TrajectoryFrame::kOdom
                                 ? OdomPoses(*entries)
                                 : placement::CorrectTrajectory(
                                       *entries, KnotsOf(view.submaps, *entries), *view.placement);
    trajectory.parts.push_back({view.segment, poses.size()});
    trajectory.poses.insert(trajectory.poses.end(), poses.begin(), poses.end());
  }
  if (!trajectory.parts.empty()) return trajectory;
  const std::vector<uint32_t>& left_out = trajectory.left_out;
  if (segment > 0 && std::count(left_out.begin(), left_out.end(), segment) == 0) {
    return absl::NotFoundError(absl::StrCat("session ", trajectory.session.value(),
                                            " has no segment ", segment, ": the last one is ",
                                            left_out.back()));
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "robot \"", robot.value(), "\" is not in the map yet: its first submap ",
      segment > 1 ? absl::StrCat("of segment ", segment, " ") : "", "is not finished"));
}

MatchGraphView PipelineImpl::GetMatchGraph() {
  std::lock_guard lock(state_.mutex);
  MatchGraphView view;
  view.revision = state_.revision.revision;
  for (const auto& [id, entry] : state_.sessions) view.nodes.push_back(id);
  view.matches = state_.EffectiveMatches();
  for (const auto& [pair, verdict] : state_.verdicts) view.verdicts.push_back(verdict);
  view.tree = state_.tree;
  view.placements = state_.revision.placements;
  return view;
}

absl::StatusOr<RobotTransform> PipelineImpl::GetTransform(const RobotId& a, const RobotId& b) {
  std::lock_guard lock(state_.mutex);
  const SessionEntry* entry_a = state_.Newest(a);
  const SessionEntry* entry_b = state_.Newest(b);
  if (entry_a == nullptr) return UnknownRobot(a);
  if (entry_b == nullptr) return UnknownRobot(b);
  const SessionId& session_a = entry_a->record.id;
  const SessionId& session_b = entry_b->record.id;
  if (session_a == session_b) return RobotTransform{state_.revision.revision, Pose()};
  if (const std::optional<Pose> T_a_b =
          match_graph::FindTransform(state_.revision.placements, session_a, session_b)) {
    return RobotTransform{state_.revision.revision, *T_a_b};
  }
  const std::optional<Match> match = state_.EffectiveMatch(std::minmax(session_a, session_b));
  return absl::FailedPreconditionError(absl::StrCat(
      "no accepted matches connect ", a.value(), " and ", b.value(), " yet: ",
      !match ? std::string("their maps have not been compared so far")
             : absl::StrCat(ToString(match->state), " (", match->reason, "): ", match->detail)));
}

std::shared_ptr<const ComposedMap> PipelineImpl::GetMap() {
  std::lock_guard lock(state_.mutex);
  return state_.map;
}

absl::Status PipelineImpl::ExportMap(ExportFormat format, const Region& region,
                                     double octomap_resolution_m,
                                     const std::function<bool(const std::string&)>& sink) {
  const bool full = format == ExportFormat::kOctoMapFull;
  if (!full && format != ExportFormat::kOctoMapBinary) {
    const std::shared_ptr<const ComposedMap> map = GetMap();
    if (region.component != 0 && region.component >= map->component_count()) {
      return absl::NotFoundError(absl::StrCat("no component ", region.component, ": the map has ",
                                              map->component_count()));
    }
    return query::ExportCloud(*map, region, CloudFormatOf(format), sink);
  }
  std::vector<PlacedSubmap> submaps;
  {
    std::lock_guard lock(state_.mutex);
    submaps = state_.PlacedSubmaps();
  }
  composition::OccupancyOptions occupancy = options_.occupancy;
  if (octomap_resolution_m > 0) occupancy.resolution_m = octomap_resolution_m;
  absl::StatusOr<std::string> file = composition::WriteOccupancy(
      submaps, [this](const SubmapId& id) { return submaps_.Get(id); }, region.component,
      full ? composition::OccupancyFormat::kFull : composition::OccupancyFormat::kBinary,
      occupancy);
  if (!file.ok()) return file.status();
  for (size_t offset = 0; offset < file->size(); offset += kFileChunk) {
    if (!sink(file->substr(offset, kFileChunk))) {
      return absl::CancelledError("the reader went away");
    }
  }
  return absl::OkStatus();
}

}  // namespace isthmus::server
