// A building of three rooms in a row, and maps of it from known poses: to be lost in.
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/submap.h"
#include "tests/floam/room.h"

namespace isthmus::floam::testing {

// 36 x 12 m, the rooms joined by doorways on the x axis, each furnished in its own way.
Room ThreeRooms();
// The same walls, furnished so that a turn by 180 degrees about the origin changes nothing.
Room SymmetricRooms();
// Another building of about that size.
Room OtherBuilding();

// The scan of a sensor that stands still.
Scan StandingScan(const Room& room, const Pose& T_world_sensor, int index);

// A submap of all points that a sensor sees that stops at each of these poses; odom is the world
// frame.
Submap MapFrom(const Room& room, const std::vector<Pose>& T_world_sensor, uint32_t index = 0);

// Stops along the x axis, a metre apart, looking ahead.
std::vector<Pose> AlongTheAxis(double from_x, double to_x);

}  // namespace isthmus::floam::testing
