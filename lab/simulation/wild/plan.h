// Plans of storeys: rooms on both sides of a corridor, and ways through them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/mesh.h"

namespace isthmus::simulation::wild {

enum class RoomUse { kLiving, kBed, kKitchen, kBath, kCell, kOpenPlan, kMeeting, kStore, kStairs };

// A room beside the corridor. Its sides are the middles of its walls.
struct PlannedRoom {
  RoomUse use = RoomUse::kLiving;
  Eigen::Vector2d min = Eigen::Vector2d::Zero(), max = Eigen::Vector2d::Zero();
  bool north = false;  // Its door is on its low side in y; else on its high side.
  double door_x = 0;
  // From inside of the door around and back, where nothing is to stand.
  std::vector<Eigen::Vector2d> round = {};

  Eigen::Vector2d Size() const { return max - min; }
  // A place so far behind the corridor's wall.
  Eigen::Vector2d Behind(double x, double into_m) const {
    return {x, north ? min.y() + into_m : max.y() - into_m};
  }
};

// The corridor lies along x from 0 on, its middle at y = 0; storeys are above each other and alike.
struct Plan {
  double length_m = 0, corridor_m = 0;
  double storey_m = 0, slab_m = 0.3;  // From floor to floor; of it the slab.
  int storeys = 1;
  double door_m = 1, door_high_m = 2;
  double flight_m = 1.2;  // Width of stairs, of which there are two flights to a storey.
  std::vector<PlannedRoom> rooms = {};

  double clear_height() const { return storey_m - slab_m; }
  double landing_m() const { return flight_m + 0.3; }
  const PlannedRoom* stairs() const;  // Null if there are none.
  // Length of a flight from above: as steep as the room demands, but not less than stairs are.
  double run_m(const PlannedRoom& stairs_room) const {
    return std::min(stairs_room.Size().y() - 2 * landing_m(), storey_m / 2 / 0.5);
  }
};

// The base and the height of what must come through.
struct Passage {
  double base_m = 0.5, height_m = 1;
};

// Puts a row of rooms beside the corridor, `depth_m` deep, from its beginning on.
struct RowOfRooms {
  bool north = false;
  double depth_m = 4;
  struct Wish {
    RoomUse use;
    double width_m;
  };
  std::vector<Wish> rooms = {};
};
void AddRow(const RowOfRooms& row, const Passage& passage, Random& random, Plan* plan);

// Floors, ceilings, walls with doors and windows, stairs.
void AddPlanTo(const Plan& plan, Random& random, Mesh* mesh);

// An outing along the corridor into rooms whose doors are between two places, taken again and
// again: `length_m` or more. With `climbs` also to other storeys, else on the lowest. Corners of a
// path.
struct Outing {
  double from_x = 0, to_x = 0;
  double length_m = 0;
  bool climbs = false;
  double aside_m = 0;  // So far from the corridor's middle.
};
std::vector<Eigen::Vector3d> StrollThrough(const Plan& plan, const Outing& outing, Random& random);

}  // namespace isthmus::simulation::wild
