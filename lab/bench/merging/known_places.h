// Anchors for robots of a benchmark: what they are told about where they are.
#pragma once

#include <cstdint>

#include "lab/bench/merging/driven_robot.h"

namespace isthmus::bench {

struct KnownPlaces {
  double gnss_m = 0;  // Standard deviation in plan, at every third submap; 0: no receiver.
  // Standard deviation of the first submap's place in plan, with half of it in height and the
  // heading to 5 degrees; 0: not told.
  double start_m = 0;
};

// Adds anchors of which the errors are normal and independent, in the frame of the truth.
void AddAnchors(const KnownPlaces& known, uint64_t seed, DrivenRobot* robot);

}  // namespace isthmus::bench
