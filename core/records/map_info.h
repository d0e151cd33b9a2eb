// The merged map as a whole: its components, and how the server is getting on with it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"
#include "core/map/datum.h"
#include "core/map/map_name.h"
#include "core/records/replica_state.h"

namespace isthmus {

struct Component {
  uint32_t component = 0;
  SessionId reference;  // Names the component's map frame.
  std::vector<SessionId> sessions;
  std::vector<RobotId> robots;  // Sorted.
  uint64_t point_count = 0;     // As composed.
  Box bounds;                   // Map frame; empty when there are no points.
};

struct MapInfo {
  int64_t revision = 0;
  std::vector<RobotId> robots;
  std::vector<Component> components;  // The largest first.
  bool settled = false;           // Nothing is queued: no scan, submap, estimation or composition.
  double composition_ms = 0;      // Last composition of the global map, wall time.
  double composition_max_ms = 0;  // The longest since the server started.
  double estimation_ms = 0;       // Last round of transform estimation, wall time.
  double placement_ms = 0;        // Last optimisation of the submaps' poses, wall time.
  uint64_t compositions = 0, estimations = 0, placements = 0;  // Since the server started.
  uint64_t submaps = 0;                                        // In the map.
  uint64_t retired = 0;  // Replaced by newer ones of the same ground, since the server started.
  // Submaps that were found damaged since the server started, in the store's words: they are left
  // out of the map, the rest is served.
  std::vector<std::string> damaged;
  // Why what comes in cannot be stored at the moment, for people; empty while it can. Nothing is
  // acknowledged as durable meanwhile, readers are served, and it ends by itself.
  std::string storage_problem = {};
  std::optional<Datum> datum = {};
  std::optional<ReplicaState> replica = {};  // For a server that only reads the map.
};

// The number of the map that the session lies in; nothing where it lies in none.
std::optional<uint32_t> MapWith(const MapInfo& info, const SessionId& session);

// The number that the map has there; NotFound where it is not among them.
absl::StatusOr<uint32_t> NumberIn(const MapInfo& info, const MapName& map);

}  // namespace isthmus
