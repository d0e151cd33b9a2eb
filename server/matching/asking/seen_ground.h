// The ground that a robot would come to know on its way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/matching/asking/driven_ways.h"

namespace isthmus::matching {

// Square metres of ground that was seen well.
struct SharedGround {
  double now_m2 = 0;  // By both robots.
  // By stop: that the driver would see so for the first time on the way there, which the other saw
  // from the stops on it. Zero for stops that are not reached.
  std::vector<double> new_m2;
};

// The driver is the robot of b, else that of a.
SharedGround MeasureSharedGround(const std::vector<Stop>& stops, const ShortestWays& ways,
                                 bool driver_is_b, bool outdoors);

}  // namespace isthmus::matching
