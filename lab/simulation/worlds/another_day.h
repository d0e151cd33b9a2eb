// A world on another day: furniture and goods that were carried off, brought or put elsewhere.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Geometry>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/worlds/world.h"

namespace isthmus::simulation {

// A piece that came or went: the box around it, world frame.
struct MovedVolume {
  bool came = false;
  Eigen::AlignedBox3d bounds;
};

// Takes `count` loose pieces, each once at most, and puts three in five of them elsewhere, takes
// one in five away, and brings another like one in five. They stand clear of roads, of each other
// and of where anything stood before. What moved both went and came. InvalidArgument where the
// world has fewer loose pieces.
absl::StatusOr<std::vector<MovedVolume>> MoveFurniture(int count, Random& random, World* world);

}  // namespace isthmus::simulation
