// The ground that a robot would come to see on its way, and what stands there to tell it from other
// places.
#pragma once

#include <vector>

#include "server/matching/asking/driven_ways.h"

namespace isthmus::matching {

// The evidence of a stretch of a map: ground that was seen well, points that the map does not
// repeat, and things.
struct Evidence {
  double ground_m2 = 0;
  double distinctive = 0;
  double things = 0;  // None outdoors, where they are not looked for.
};

struct SharedGround {
  double now_m2 = 0;  // Seen well by both robots.
  // By stop: what the driver would see well for the first time on the way there, as the other robot
  // did from the stops on it. Nothing for stops that are not reached.
  std::vector<Evidence> ahead;
};

// The driver is the robot of b, else that of a; `other` is the other's map.
SharedGround MeasureSharedGround(const std::vector<Stop>& stops, const EasiestWays& ways,
                                 bool driver_is_b, const PreparedMap& other, bool outdoors);

}  // namespace isthmus::matching
