// The limit on a map's number of tiles, and the choice of those it keeps.
//
// A tile costs some hundred bytes and microseconds however little lies on it, so points strewn over
// the plane, which no LiDAR measures but an upload may hold, would cost a tile each. Which points a
// LiDAR can have measured is not known: an upload need not say where its sensor stood. But what was
// measured lies hundreds of points to a tile. So the tiles with most points stay.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/composition/tiles/tile_layout.h"

namespace isthmus::composition {

// The number of points that a tile must have so that at most `max_tiles` of them stay: those with
// most. Of equals all stay or none, so that it does not depend on any order. At least 1.
uint64_t FewestPoints(std::vector<uint64_t> points_of_tiles, size_t max_tiles);

// The limit over all submaps together. Not thread safe.
class TileLimit {
 public:
  explicit TileLimit(size_t max_tiles) : max_tiles_(max_tiles) {}

  void Add(const TileKey& tile, uint64_t points);
  // As many as were added, or fewer.
  void Remove(const TileKey& tile, uint64_t points);
  // Works out anew which tiles stay. True if others may than before: never while there is room for
  // all.
  bool Update();
  // As of the last Update.
  bool has_room_for_all() const { return fewest_ == 1; }
  bool Stays(const TileKey& tile) const;

  // Calls visit(tile) for every tile that has points, in no order.
  template <typename Visit>
  void ForEach(const Visit& visit) const {
    for (const auto& [tile, points] : points_on_) visit(tile);
  }

 private:
  const size_t max_tiles_;
  absl::flat_hash_map<TileKey, uint64_t> points_on_;  // None is 0.
  uint64_t fewest_ = 1;                               // Points of a tile that stays.
};

}  // namespace isthmus::composition
