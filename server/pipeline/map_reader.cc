#include "server/pipeline/map_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <thread>
#include <utility>

#include "server/match_graph/match_graph.h"

namespace isthmus::server {
namespace {

// Null where it is not placed.
const SubmapPose* FindPose(const Placement* placement, uint32_t index) {
  if (placement == nullptr) return nullptr;
  const auto it =
      std::lower_bound(placement->submaps.begin(), placement->submaps.end(), index,
                       [](const SubmapPose& pose, uint32_t wanted) { return pose.index < wanted; });
  return it == placement->submaps.end() || it->index != index ? nullptr : &*it;
}

}  // namespace

absl::Status UnknownRobot(const RobotId& robot) {
  return absl::NotFoundError(
      absl::StrCat("no robot \"", robot.value(), "\" has opened a session on this server"));
}

MapReader::MapReader(const MapWriter* map, const storage::MapStore* store, SubmapCache* submaps,
                     const composition::OccupancyOptions& occupancy)
    : map_(map),
      store_(store),
      submaps_(submaps),
      occupancy_(occupancy),
      turns_(std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 2)) {}

MapInfo MapReader::Describe(const MapView& view) {
  MapInfo info;
  info.revision = view.revision->revision;
  info.retired = view.retired;
  std::set<RobotId> robots;
  for (const auto& [id, session] : view.sessions) robots.insert(session.record.robot);
  info.robots.assign(robots.begin(), robots.end());
  for (const Placement& placement : view.revision->placements) {
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
    component.point_count = view.map->point_count(component.component);
    component.bounds = view.map->bounds(component.component);
  }
  return info;
}

absl::StatusOr<std::vector<SubmapStatus>> MapReader::ListSubmaps(
    const std::optional<RobotId>& robot) const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  if (robot && view->Newest(*robot) == nullptr) return UnknownRobot(*robot);
  std::vector<SubmapStatus> list;
  for (const auto& [id, session] : view->sessions) {
    if (robot && session.record.robot != *robot) continue;
    const Placement* placement = view->PlacementOf(id);
    for (const auto& [index, info] : session.submaps) {
      SubmapStatus& status = list.emplace_back();
      status.info = info;
      const SubmapPose* pose = FindPose(placement, index);
      if (pose == nullptr) continue;
      status.component = placement->component;
      status.T_map_submap = pose->T_map_submap;
    }
  }
  return list;
}

MatchGraphView MapReader::GetMatchGraph() const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  MatchGraphView graph;
  graph.revision = view->revision->revision;
  for (const auto& [id, session] : view->sessions) graph.nodes.push_back(id);
  graph.matches = *view->effective;
  for (const auto& [pair, verdict] : view->verdicts) graph.verdicts.push_back(verdict);
  graph.tree = *view->tree;
  graph.placements = view->revision->placements;
  return graph;
}

LoopStatus MapReader::StatusOf(const LoopClosure& loop, const MapView& view) {
  LoopStatus status{loop};
  const auto it = view.judgement->loops.find(loop.id);
  if (it == view.judgement->loops.end() || loop.rejected) return status;
  status.edges_used = static_cast<uint32_t>(std::count(it->second.begin(), it->second.end(), true));
  return status;
}

absl::StatusOr<std::vector<LoopStatus>> MapReader::ListLoops(
    const std::optional<RobotId>& robot) const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  if (robot && view->Newest(*robot) == nullptr) return UnknownRobot(*robot);
  std::vector<LoopStatus> list;
  for (const auto& [id, loop] : view->loops) {
    const SessionView* session = view->Find(loop.session);
    if (session == nullptr || (robot && session->record.robot != *robot)) continue;
    list.push_back(StatusOf(loop, *view));
  }
  return list;
}

std::vector<Anchor> MapReader::ListAnchors() const {
  const MapWriter::View view = map_->view();
  std::vector<Anchor> list;
  for (const auto& [submap, anchor] : view->anchors) list.push_back(anchor);
  return list;
}

absl::StatusOr<RobotTransform> MapReader::GetTransform(const RobotId& a, const RobotId& b) const {
  const MapWriter::View view = map_->view();
  const SessionView* newest_a = view->Newest(a);
  const SessionView* newest_b = view->Newest(b);
  if (newest_a == nullptr) return UnknownRobot(a);
  if (newest_b == nullptr) return UnknownRobot(b);
  const SessionId& session_a = newest_a->record.id;
  const SessionId& session_b = newest_b->record.id;
  const int64_t revision = view->revision->revision;
  if (session_a == session_b) return RobotTransform{revision, Pose()};
  if (const std::optional<Pose> T_a_b =
          match_graph::FindTransform(view->revision->placements, session_a, session_b)) {
    return RobotTransform{revision, *T_a_b};
  }
  const Match* match = view->EffectiveMatch(std::minmax(session_a, session_b));
  return absl::FailedPreconditionError(absl::StrCat(
      "no accepted matches connect ", a.value(), " and ", b.value(), " yet: ",
      match == nullptr
          ? std::string("their maps have not been compared so far")
          : absl::StrCat(ToString(match->state), " (", match->reason, "): ", match->detail)));
}

}  // namespace isthmus::server
