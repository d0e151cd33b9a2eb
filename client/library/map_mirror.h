// A copy of the merged map that follows the server's, tile by tile.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "client/library/client.h"
#include "core/records/map_changes.h"

namespace isthmus::client {

// Asks for a tile only when it has changed, and for none that it has under another name already, as
// when components are numbered anew. Not thread safe.
class MapMirror {
 public:
  // The client must outlive it. Level 0 is the map as it is, see ComposedMap.
  explicit MapMirror(Client* client, uint32_t level = 0) : client_(*client), level_(level) {}

  // Called with the mirror itself whenever that is the server's map of its revision, no more and no
  // less, and something is new in it or in where robots are. False ends the following.
  using AtMap = std::function<bool(const MapMirror& mirror)>;
  // Follows the map from what the mirror holds, nothing at first, until told to end (OK). Fails as
  // Client::WatchMap; it may be called again then, and goes on.
  absl::Status Follow(const AtMap& at_map);

  struct Tile {
    uint64_t version = 0;
    std::vector<RobotId> robots = {};  // MapPoint::robot indexes it.
    std::vector<MapPoint> points = {};
  };

  int64_t revision() const { return mark_.revision; }
  const std::map<TileId, std::shared_ptr<const Tile>>& tiles() const { return held_; }
  const std::map<SubmapId, SubmapPlace>& submaps() const { return submaps_; }
  const std::vector<RobotPlace>& robots() const { return robots_; }
  // All points of a component, as a query for everything gives them, if not in that order.
  RegionChunk Points(uint32_t component) const;
  uint64_t tiles_fetched() const { return tiles_fetched_; }

 private:
  // Notes the step, and asks for the tiles that differ from it.
  absl::Status Take(const MapStep& step);
  void Note(const MapStep& step);
  absl::Status Fetch(const TileId& id, uint64_t version,
                     const std::map<uint64_t, std::shared_ptr<const Tile>>& known);

  Client& client_;
  const uint32_t level_;
  MapMark mark_;
  std::map<TileId, uint64_t> told_;  // The versions of the map of mark_.
  std::map<TileId, std::shared_ptr<const Tile>> held_;
  std::set<TileId> differing_;  // Between told_ and held_.
  std::map<SubmapId, SubmapPlace> submaps_;
  std::vector<RobotPlace> robots_;
  uint64_t tiles_fetched_ = 0;
};

}  // namespace isthmus::client
