#include "server/pipeline/view_reader.h"

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

// The drive where the map has its submaps; nothing where one of these is gone, or the robot.
std::optional<RobotDrive> Locate(const AskedDrive& asked, const Match& match, const MapView& view) {
  const SessionId& id = asked.by_b ? match.b : match.a;
  const SessionView* session = view.Find(id);
  if (session == nullptr || session->record.finished_ns != 0) return std::nullopt;
  if (asked.rival > match.rivals.size()) return std::nullopt;
  RobotDrive drive;
  drive.robot = session->record.robot;
  drive.session = id;
  drive.T_a_b = asked.rival == 0 ? match.T_a_b : match.rivals[asked.rival - 1].T_a_b;
  const Placement* placement = view.PlacementOf(id);
  for (const WayPoint& point : asked.way) {
    const SubmapPose* pose = FindPose(placement, point.submap);
    if (pose == nullptr) return std::nullopt;
    drive.way.push_back(pose->T_map_submap * point.position);
  }
  drive.leaves_own = asked.leaves_own;
  drive.length_m = asked.length_m;
  drive.confidence = asked.confidence;
  return drive;
}

// Empty for a session that is gone.
RobotId RobotOf(const SessionId& session, const MapView& view) {
  const SessionView* known = view.Find(session);
  return known == nullptr ? RobotId() : known->record.robot;
}

void AddSession(const Placement& placement, const MapView& view, Component& component) {
  component.component = placement.component;
  component.reference = placement.reference;
  component.sessions.push_back(placement.session);
  const RobotId robot = RobotOf(placement.session, view);
  const auto place = std::lower_bound(component.robots.begin(), component.robots.end(), robot);
  const bool is_known = place != component.robots.end() && *place == robot;
  if (!robot.empty() && !is_known) component.robots.insert(place, robot);
}

}  // namespace

absl::Status UnknownRobot(const RobotId& robot) {
  return absl::NotFoundError(
      absl::StrCat("no robot \"", robot.value(),
                   "\" has opened a session on this server; `isthmus robots` lists those that "
                   "have"));
}

ViewReader::ViewReader(const MapWriter* map, const storage::MapStore* store, SubmapCache* submaps,
                       const ingest::SessionWorkers* workers,
                       const composition::OccupancyOptions& occupancy,
                       uint64_t kept_occupancy_bytes)
    : map_(map),
      store_(store),
      submaps_(submaps),
      workers_(workers),
      occupancy_(occupancy),
      kept_occupancy_(kept_occupancy_bytes),
      turns_(std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 2)) {}

MapInfo ViewReader::Describe(const MapView& view) const {
  MapInfo info;
  info.revision = view.revision->revision;
  info.retired = view.retired;
  info.datum = view.datum;
  std::set<RobotId> robots;
  for (const auto& [id, session] : view.sessions) robots.insert(session.record.robot);
  info.robots.assign(robots.begin(), robots.end());
  for (const Placement& placement : view.revision->placements) {
    if (info.components.size() <= placement.component) {
      info.components.resize(placement.component + 1);
    }
    AddSession(placement, view, info.components[placement.component]);
    info.submaps += placement.submaps.size();
  }
  // Between a new revision and its composition the older map is served, and described.
  for (Component& component : info.components) {
    component.point_count = view.map->point_count(component.component);
    component.bounds = view.map->bounds(component.component);
  }
  return info;
}

absl::StatusOr<ListAt<SubmapStatus>> ViewReader::ListSubmaps(
    const std::optional<RobotId>& robot) const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  if (robot && view->Newest(*robot) == nullptr) return UnknownRobot(*robot);
  ListAt<SubmapStatus> list;
  list.revision = view->revision->revision;
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

MatchEdge ViewReader::Describe(const Match& match, const MapView& view) {
  const SessionPair pair(match.a, match.b);
  MatchEdge edge{match, RobotOf(match.a, view), RobotOf(match.b, view)};
  edge.in_tree = std::binary_search(view.tree->begin(), view.tree->end(), pair);
  if (const ManualDecision* said = view.manual_decisions.Find(pair)) edge.manual_decision = *said;
  if (match.state == MatchState::kAccepted || edge.manual_decision) return edge;
  for (const AskedDrive& asked : match.asked) {
    if (auto drive = Locate(asked, match, view)) edge.asked_drives.push_back(*std::move(drive));
  }
  return edge;
}

MatchGraph ViewReader::GetMatchGraph() const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  MatchGraph graph;
  graph.revision = view->revision->revision;
  for (const Match& match : *view->effective) graph.matches.push_back(Describe(match, *view));
  for (const Placement& placement : view->revision->placements) {
    graph.placements.push_back(
        {{placement.session, placement.component, placement.reference, placement.T_map_odom},
         RobotOf(placement.session, *view)});
  }
  return graph;
}

Loop ViewReader::Describe(const LoopClosure& loop, const MapView& view) {
  Loop told{loop, RobotOf(loop.session, view), static_cast<uint32_t>(loop.edges.size())};
  const auto it = view.edge_status->loops.find(loop.id);
  if (it == view.edge_status->loops.end() || loop.rejected) return told;
  told.edges_used = static_cast<uint32_t>(std::count(it->second.begin(), it->second.end(), true));
  return told;
}

absl::StatusOr<ListAt<Loop>> ViewReader::ListLoops(const std::optional<RobotId>& robot) const {
  const Turn turn(turns_);
  const MapWriter::View view = map_->view();
  if (robot && view->Newest(*robot) == nullptr) return UnknownRobot(*robot);
  ListAt<Loop> list;
  list.revision = view->revision->revision;
  for (const auto& [id, loop] : view->loops) {
    const SessionView* session = view->Find(loop.session);
    if (session == nullptr || (robot && session->record.robot != *robot)) continue;
    list.push_back(Describe(loop, *view));
  }
  return list;
}

ListAt<RobotAnchor> ViewReader::ListAnchors(const MapView& view) const {
  ListAt<RobotAnchor> list;
  list.revision = view.revision->revision;
  for (const auto& [submap, anchor] : view.anchors) {
    list.push_back({anchor, RobotOf(submap.session, view)});
  }
  return list;
}

absl::StatusOr<RobotTransform> ViewReader::GetTransform(const RobotId& a, const RobotId& b) const {
  const MapWriter::View view = map_->view();
  const SessionView* newest_a = view->Named(a);
  const SessionView* newest_b = view->Named(b);
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
  return absl::FailedPreconditionError(
      absl::StrCat("no accepted matches connect ", a.value(), " and ", b.value(), " yet: ",
                   match == nullptr ? std::string("their maps have not been compared so far")
                                    : absl::StrCat(ToString(match->state), " (",
                                                   ToString(match->reason), "): ", match->detail)));
}

}  // namespace isthmus::server
