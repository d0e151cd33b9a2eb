// Composition: the placed submaps thinned into one map, tile by tile. Runs often, with whatever
// transforms are at hand; recomputes only tiles whose submaps came, went or moved.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/composed_map.h"

namespace isthmus::composition {

struct ComposerOptions {
  double tile_m = 20;    // Edge of a square tile in x and y; unbounded in z.
  double voxel_m = 0.1;  // One point per voxel and robot.
  // A placement that moved less than this since a tile was made does not remake it.
  double min_move_m = 0.005;
};

// Not thread safe; one thread composes.
class Composer {
 public:
  explicit Composer(const ComposerOptions& options);
  ~Composer();

  // The map with exactly these submaps at these poses.
  std::shared_ptr<const ComposedMap> Compose(int64_t revision,
                                             const std::vector<PlacedSubmap>& submaps);
  // Tiles that the last Compose remade.
  int last_tiles_remade() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::composition
