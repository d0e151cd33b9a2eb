// Where every session lies in the merged map, as of one revision.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

// A session in its component. Each component has one map frame; it is the odom frame of the
// component's reference session.
struct Placement {
  SessionId session;
  uint32_t component = 0;  // 0 is the largest component; every lone session is one of its own.
  SessionId reference;     // The session whose odom frame is this component's map frame.
  Pose T_map_odom;
};

// Grows by one whenever a placement is added, removed or moved. Revision 0 is the empty map.
struct MapRevision {
  int64_t revision = 0;
  int64_t stamp_ns = 0;
  std::string cause;                  // For a person: "match alice-1 ~ bob-1 accepted".
  std::vector<Placement> placements;  // In order of session id.
};

}  // namespace isthmus
