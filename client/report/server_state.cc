#include "client/report/server_state.h"

#include <algorithm>
#include <utility>

#include "client/exports/tracks.h"
#include "client/report/limits.h"
#include "core/records/map_tracks.h"

namespace isthmus::report {
namespace {

absl::StatusOr<ComponentMap> ReadMap(client::Client& client, const MapInfo& info,
                                     const Component& component) {
  ComponentMap map;
  map.component = component.component;
  RegionQuery query;
  query.component = MapName(component.reference);  // Its number may mean another one by now.
  const Eigen::Vector3d size = component.bounds.max - component.bounds.min;
  query.resolution_m = std::max(size.x(), size.y()) / kMapSidePx;
  const absl::Status status = client.QueryRegion(query, [&map](const RegionChunk& chunk) {
    map.robots = chunk.robots;
    map.points.insert(map.points.end(), chunk.points.begin(), chunk.points.end());
    return true;
  });
  if (!status.ok()) return status;
  auto tracks = ReadTracks(exports::TracksOf(client), info, query.component);
  if (!tracks.ok()) return tracks.status();
  map.ways = NewestWays(*std::move(tracks), map.robots);
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
    auto map = ReadMap(client, state.info, component);
    if (!map.ok()) return map.status();
    state.maps.push_back(*std::move(map));
  }
  return state;
}

}  // namespace isthmus::report
