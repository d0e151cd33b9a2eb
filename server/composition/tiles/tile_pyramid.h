// A component's tiles of higher levels: what is known of them without making them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cloud.h"
#include "server/composition/tiles/tile.h"

namespace isthmus::composition {

// Immutable.
class TilePyramid {
 public:
  // As TileInfo's.
  struct Node {
    int32_t x = 0, y = 0;
    uint64_t version = 0;
    int64_t revision = 0;
    uint64_t points = 0;
    Box bounds;
  };

  TilePyramid() = default;
  // The pyramid of the map of this revision. `tiles` are in order. `before` is the pyramid of the
  // map before, null if there was none: nodes with the same version there keep their revision.
  TilePyramid(const std::vector<TilePtr>& tiles, int64_t revision, const TilePyramid* before);

  // Levels above 0, which are the tiles themselves: none where there are four at most.
  size_t levels() const { return levels_.size(); }
  // In order of x, then y. Empty for level 0 and those that there are not.
  const std::vector<Node>& level(uint32_t level) const;
  const Node* Find(uint32_t level, int32_t x, int32_t y) const;  // Null: no such tile.

 private:
  std::vector<std::vector<Node>> levels_;  // From level 1.
};

}  // namespace isthmus::composition
