// Storeys of simulated buildings as grid maps, with and without furniture.
#pragma once

#include <cstdint>

#include "core/floors/grid_map.h"
#include "lab/bench/rooms/judge.h"

namespace isthmus::bench {

struct DrawnHouse {
  floors::GridMap bare, furnished;  // Both have the same cells.
  TrueRooms truth;
};

// A flat or an office of the simulator's rooms, as `seed` draws it, turned by up to a right angle.
// Cells are occupied where anything is 0.1 to 1 m above the floor, free where a way leads to them
// from the corridor, and unknown else. True rooms end in the middles of walls.
DrawnHouse DrawHouse(uint64_t seed);

}  // namespace isthmus::bench
