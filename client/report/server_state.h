// The state of a server, read once for a report.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/library/client.h"

namespace isthmus::report {

// The points of one component from above, and the ways of its robots.
struct ComponentMap {
  uint32_t component = 0;
  std::vector<RobotId> robots;  // MapPoint::robot indexes it.
  std::vector<MapPoint> points;
  std::vector<Trajectory> ways;  // T_map_sensor, one per robot; empty where it has none.
};

struct ServerState {
  std::string address;
  MapInfo info;
  std::vector<SessionStatus> sessions;
  MatchGraph graph;
  std::vector<Loop> loops;
  std::vector<RevisionInfo> revisions;  // The newest first.
  std::vector<ComponentMap> maps;       // The largest first; those with points.
};

// Errors are the server's. `with_maps`: with the points of the kMostMaps largest components,
// thinned to what a picture shows. The answers are of one moment each, not of one together.
absl::StatusOr<ServerState> ReadServerState(client::Client& client, bool with_maps);

}  // namespace isthmus::report
