// The ground that a robot would come to know on its way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/matching/asking/driven_ways.h"

namespace isthmus::matching {

// Square metres of ground that the robot, of b or of a, would see for the first time on the way to
// each stop: what the other saw from the stops on it. Zero for stops that are not reached.
std::vector<double> NewGround(const std::vector<Stop>& stops, const ShortestWays& ways,
                              bool driver_is_b);

}  // namespace isthmus::matching
