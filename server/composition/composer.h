// Composition: the placed submaps thinned into one map, tile by tile. Runs often, with whatever
// transforms are at hand; recomputes only tiles whose submaps came, went or moved.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/composed_map.h"

namespace isthmus::composition {

// Values out of range are brought to the nearest sensible one: voxels of at least 1 mm, tiles of at
// least one voxel.
struct ComposerOptions {
  // Edge of a square tile in x and y, rounded to whole voxels; unbounded in z.
  double tile_m = 20;
  // One point per voxel and robot: the mean of what fell into it, from whichever submap.
  double voxel_m = 0.1;
  // A submap of which no point would move by more than this since it was last composed stays where
  // it is, and its tiles with it.
  double min_move_m = 0.005;
};

// Not thread safe; one thread composes.
class Composer {
 public:
  explicit Composer(const ComposerOptions& options);
  ~Composer();

  // The map with exactly these submaps at these poses (to min_move_m). The result does not depend
  // on what was composed before or on the order of `submaps`. Submaps are read and thinned when
  // first seen and known again by what is said of them. Submaps without points, a null pointer or a
  // pose that is not finite add nothing, nor do points that are not finite or more than a million
  // voxels from the origin of the map. One that the reader has not is left out, counted as missing
  // and asked for again the next time. The map never changes and shares unchanged tiles with those
  // made before; it may outlive the composer.
  std::shared_ptr<const ComposedMap> Compose(int64_t revision,
                                             const std::vector<PlacedSubmap>& submaps,
                                             const SubmapReader& reader);
  // Tiles that the last Compose remade.
  int last_tiles_remade() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::composition
