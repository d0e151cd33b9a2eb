// The division of a component's plane into tiles.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>
#include <utility>

#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// A tile's place. `frame` is the composer's own number of a map frame: unlike the number of a
// component it does not change when another component grows.
struct TileKey {
  uint32_t frame = 0;
  int32_t x = 0, y = 0;

  friend auto operator<=>(const TileKey&, const TileKey&) = default;
  friend bool operator==(const TileKey&, const TileKey&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const TileKey& key) {
    return H::combine(std::move(h), key.frame, key.x, key.y);
  }
  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.frame, self.x, self.y);
  }
};

// Cuts the plane into squares of whole voxels, so that no voxel lies in two tiles. Value type.
class TileLayout {
 public:
  // `tile_m` is rounded to a multiple of `voxel_m`, at least one.
  TileLayout(double tile_m, double voxel_m)
      : voxels_(std::fmax(1, std::round(tile_m / voxel_m))), tiles_per_voxel_(1 / voxels_) {}

  int32_t voxels() const { return static_cast<int32_t>(voxels_); }  // Along an edge of a tile.
  TileKey Find(uint32_t frame, const Voxel& voxel) const {
    return {frame, Divide(voxel.x), Divide(voxel.y)};
  }

 private:
  // Exact: a voxel's middle is at least half a voxel from the edge of a tile, which is far more
  // than what rounding can move it for indices below 2^20.
  int32_t Divide(int32_t index) const {
    return static_cast<int32_t>(std::floor((index + 0.5) * tiles_per_voxel_));
  }

  double voxels_, tiles_per_voxel_;
};

}  // namespace isthmus::composition
