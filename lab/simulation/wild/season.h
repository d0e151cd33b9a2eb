// The days of a world: furniture, goods, containers and leaves that are elsewhere, or gone.
#pragma once

#include <cstdint>

#include "lab/simulation/random.h"

namespace isthmus::simulation::wild {

// Value type. Days of one world differ in a share of its loose things only.
struct Season {
  uint64_t world = 0, day = 0;  // Seeds.
  double changed = 0;           // Probability that a loose thing is not as it is in the world.
  double leaves = 1;            // Share of the leaves that are there.

  // The stream that draws a loose thing; things are told apart by any numbers.
  Random Draw(uint64_t thing) const {
    Random of_day(day, 0x95, thing);
    return Random(of_day.Chance(changed) ? of_day.Next() : world, 0x96, thing);
  }
  int Leaves(int count) const { return static_cast<int>(leaves * count); }
};

}  // namespace isthmus::simulation::wild
