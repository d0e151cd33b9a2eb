// Rooms that were found on a grid map against the true ones.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/floors/rooms.h"

namespace isthmus::bench {

// The true rooms of a grid map.
struct TrueRooms {
  std::vector<int32_t> labels;         // By cell of the map: the number of its room, or -1.
  std::vector<Eigen::Vector2d> doors;  // Their middles, map frame, metres.
};

// A map's figures, or sums over maps.
struct RoomScore {
  int64_t true_rooms = 0, found_rooms = 0;
  double recall = 0, precision = 0;          // Means over the rooms of a map, 0 to 1.
  int64_t true_doors = 0, doors_found = 0;   // True ones, and of these those with a found one near.
  int64_t found_doors = 0, doors_right = 0;  // Found ones, and of these those with a true one near.

  void Add(const RoomScore& other);
};

// Recall: of each true room's area what the found room that covers most of it has; precision: the
// same of each found room (Bormann and others, "Room segmentation: survey, implementation, and
// analysis", ICRA 2016). Cells count that are free on `ground`, a map of the same cells. A door is
// found within 0.5 m.
RoomScore JudgeRooms(const floors::Rooms& found, const TrueRooms& truth,
                     const floors::GridMap& ground);

}  // namespace isthmus::bench
