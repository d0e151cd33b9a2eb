// The map as it changes: steps from one composed map to the next, and where robots are meanwhile.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/ids.h"
#include "core/map/composed_map.h"
#include "core/pose.h"
#include "core/records/map_graph.h"
#include "core/records/robot_place.h"

namespace isthmus {

struct SubmapPlace {
  SubmapId submap;
  RobotId robot = {};
  std::optional<uint32_t> component = {};  // Absent: it lies nowhere any more.
  Pose T_map_submap = {};
};

// A watcher's knowledge: a revision means something only within one run of a server.
struct MapMark {
  uint64_t run = 0;
  int64_t revision = 0;
};

// A map, and what is new in it since an earlier one.
struct MapStep {
  MapMark mark = {};
  bool restart = false;  // The earlier one is none: tiles, submaps and matches are all there are.
  double tile_m = 0;     // Edge of a tile of level 0; 0 where there is no news but of robots.
  std::vector<TileInfo> tiles = {};  // New or changed ones.
  std::vector<TileId> removed_tiles = {};
  std::vector<SubmapPlace> submaps = {};
  std::vector<MatchEdge> matches = {};  // Without the submaps that carry them, where received.
  std::vector<std::pair<SessionId, SessionId>> removed_matches = {};
  // All that are under way; absent where nothing is told of them.
  std::optional<std::vector<RobotPlace>> robots = {};
};

// The tiles of a component at a level.
struct TileList {
  int64_t revision = 0;
  double tile_m = 0;    // Edge of a tile of level 0.
  uint32_t levels = 0;  // Levels of the component.
  std::vector<TileInfo> tiles = {};
};

// A tile as a client has it.
struct MapTile {
  int64_t revision = 0;  // Revision of the map that was read.
  TileInfo info = {};
  bool not_modified = false;  // It is of the version that was at hand: there are no points here.
  std::vector<RobotId> robots = {};  // MapPoint::robot indexes it.
  std::vector<MapPoint> points = {};
};

}  // namespace isthmus
