// The kinds of world behind MakeWorld.
#pragma once

#include <cstdint>

#include "lab/simulation/worlds/world.h"

namespace isthmus::simulation {

World MakeMuseum(uint64_t seed);
World MakeWarehouse(uint64_t seed);
World MakeCampus(uint64_t seed, int blocks);
World MakeCorridor(uint64_t seed);
World MakeTwins(uint64_t seed, bool joined);
World MakeLargeTwins(uint64_t seed, bool with_wings);

}  // namespace isthmus::simulation
