#include "client/report/server_state.h"

#include <algorithm>
#include <utility>

#include "client/report/limits.h"

namespace isthmus::report {
namespace {

// The way of a robot in that component's frame; empty where it has none there.
absl::StatusOr<Trajectory> WayOf(client::Client& client, const RobotId& robot, uint32_t component) {
  auto trajectory = client.GetTrajectory(robot, TrajectoryFrame::kMap);
  if (absl::IsFailedPrecondition(trajectory.status())) return Trajectory();  // Not placed.
  if (!trajectory.ok()) return trajectory.status();
  return trajectory->component == component ? std::move(trajectory->poses) : Trajectory();
}

absl::StatusOr<ComponentMap> ReadMap(client::Client& client, const Component& component) {
  ComponentMap map;
  map.component = component.component;
  RegionQuery query;
  query.component = component.component;
  const Eigen::Vector3d size = component.bounds.max - component.bounds.min;
  query.resolution_m = std::max(size.x(), size.y()) / kMapSidePx;
  const absl::Status status = client.QueryRegion(query, [&map](const RegionChunk& chunk) {
    map.robots = chunk.robots;
    map.points.insert(map.points.end(), chunk.points.begin(), chunk.points.end());
    return true;
  });
  if (!status.ok()) return status;
  for (const RobotId& robot : map.robots) {
    auto way = WayOf(client, robot, map.component);
    if (!way.ok()) return way.status();
    map.ways.push_back(*std::move(way));
  }
  return map;
}

}  // namespace

absl::StatusOr<ServerState> ReadServerState(client::Client& client, bool with_maps) {
  ServerState state;
  state.address = client.address();
  auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  state.info = *std::move(info);
  auto sessions = client.ListSessions();
  if (!sessions.ok()) return sessions.status();
  state.sessions = *std::move(sessions);
  auto graph = client.GetMatchGraph();
  if (!graph.ok()) return graph.status();
  state.graph = *std::move(graph);
  auto loops = client.ListLoops();
  if (!loops.ok()) return loops.status();
  state.loops.assign(loops->begin(), loops->end());
  auto revisions = client.ListRevisions(kMostRevisions);
  if (!revisions.ok()) return revisions.status();
  state.revisions = *std::move(revisions);
  if (!with_maps) return state;
  for (const Component& component : state.info.components) {
    if (component.point_count == 0 || state.maps.size() >= kMostMaps) continue;
    auto map = ReadMap(client, component);
    if (!map.ok()) return map.status();
    state.maps.push_back(*std::move(map));
  }
  return state;
}

}  // namespace isthmus::report
