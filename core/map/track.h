// One session's way through the map.
#pragma once

#include "core/ids.h"
#include "core/map/trajectory.h"

namespace isthmus {

struct Track {
  RobotId robot;
  SessionId session;
  Trajectory poses;  // T_map_sensor, in order of time.
};

}  // namespace isthmus
