// A robot that is found in the map, as people read it.
#pragma once

#include <cstdint>
#include <string>

#include "core/records/robot_place.h"

namespace isthmus::cli {

// "(unnamed)" for one that gave none; no robot's name has brackets.
std::string NameOf(const RobotPlace& place);
// "at 1.00, 2.00, 0.50 of map 0"; empty where it has no place.
std::string PlaceText(const RobotPlace& place);
// "localised since 00:01:03: located at 1.00, 2.00, 0.50 of map 0; 621 scans, 9.8/s, the last
// 0.1 s ago". Only for one that is localised; `now_ns` is the server's clock.
std::string LocalisingText(const RobotPlace& place, int64_t now_ns);

}  // namespace isthmus::cli
