// The rooms of a floor and the doors between them, found on its grid map.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/floors/grid_map.h"
#include "core/floors/outline.h"

namespace isthmus::floors {

struct Room {
  bool is_corridor = false;
  double area_m2 = 0;                                // Includes what stands freely on the ground.
  Eigen::Vector2d inside = Eigen::Vector2d::Zero();  // The place that is farthest from all walls.
  Outline outline = {};                              // Counterclockwise.
  std::vector<Outline> holes = {};                   // Clockwise; each as large as a room.
};

struct Door {
  std::array<Eigen::Vector2d, 2> ends = {};  // The corners of walls between which it is.
  double width_m = 0;
  std::array<int32_t, 2> rooms = {-1, -1};  // Numbers of the rooms that it joins, the lower first.
};

// Map frame, metres.
struct Rooms {
  std::vector<Room> rooms;
  std::vector<Door> doors;
  std::vector<int32_t> labels;  // By cell of the map: the number of its room, or -1.
};

// Rooms are numbered by their first cells, the lowest y first. ResourceExhausted beyond
// kMostRoomCells.
absl::StatusOr<Rooms> RoomsOf(const GridMap& map);

}  // namespace isthmus::floors
