// Things that stand on a floor, told from its walls by their size.
#pragma once

#include "core/floors/distance.h"
#include "core/floors/grid_map.h"

namespace isthmus::floors {

// Free cells, and what stands on the ground without touching a wall and is no larger than
// kLooseM: legs of tables, chairs, plants, places that no ray reached.
Mask OpenGround(const GridMap& map);

// All that is not open ground, by its thickness. Parts of a thickness are an opening by a disc
// (Serra, "Image analysis and mathematical morphology", 1982).
struct Solids {
  Mask thick;      // Open where it is thicker than kThickestWallM.
  Mask furniture;  // Open where `thick` is thinner than kThickestFurnitureM.
};
Solids SolidsOf(const Mask& ground, double resolution_m);

}  // namespace isthmus::floors
