// A tile's points as they lie in memory and in the file, and the order they lie in.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/map/point_class.h"
#include "server/composition/limits.h"

namespace isthmus::composition {

// Map frame. These bytes are nearly all that a tile costs.
struct TilePoint {
  float x = 0, y = 0, z = 0;
  float intensity = 0;
  PointClass label = PointClass::kUnknown;
  uint32_t stamp = 0;  // As MapPoint's.
};
static_assert(sizeof(TilePoint) == 24);

// Points of one robot on a tile, coarse to fine: those before level_end[k] have one for each voxel
// of voxel_m * 2^k in which it has any, so a prefix is a level of detail. All of them are before
// level_end[0]. Of points in the same voxel it is that in the lowest octant, and in that one's, and
// so on; points of the same level follow each other along a Z-order curve.
struct TilePart {
  uint32_t robot = 0;  // The composer's own number of a robot; never reused.
  uint32_t begin = 0;
  std::array<uint32_t, kDetailLevels> level_end = {};

  uint32_t end() const { return level_end[0]; }
  // End of the points of a level of detail; of the coarsest one if there is none so coarse.
  uint32_t EndOf(uint32_t level) const { return level_end[std::min(level, kDetailLevels - 1)]; }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.robot, self.begin, self.level_end);
  }
};

}  // namespace isthmus::composition
