// Plans of buildings: rooms that share walls, doors in these walls, and the way through.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/worlds/road_map.h"
#include "lab/simulation/worlds/world.h"

namespace isthmus::simulation {

// Axis-aligned room; the walls' middle lines are its sides.
struct Room {
  Eigen::Vector2d min, max;
  double ceiling_m = 4.5;
  double ring_inset_m = 2.2;  // Distance of the robots' ring from the walls, if there is room.

  Eigen::Vector2d Size() const { return max - min; }
  Eigen::Vector2d Center() const { return (min + max) / 2; }
};

// A doorway in the wall between rooms a and b.
struct Door {
  int a = 0, b = 0;
  Eigen::Vector2d center;
  Eigen::Vector2d across;  // Unit vector through the doorway from a to b.
  double width_m = 2;
  double height_m = 2.4;
};

// A straight wall along an axis, standing on its middle line.
struct Wall {
  Eigen::Vector2d from, to;
};

struct FloorPlan {
  std::vector<Room> rooms;
  std::vector<Wall> walls;
  std::vector<Door> doors;
};

constexpr double kWallThickness = 0.3;
constexpr double kWallHeight = 5.2;  // Above the highest ceiling.

// Divides a rectangle from the origin to `size` into rooms with sides of 7.5 to about 20 m, joined
// by doors so that every room can be reached.
FloorPlan MakeFloorPlan(const Eigen::Vector2d& size, Random& random);

// Walls with the doorways left out, floors and ceilings.
void BuildFloorPlan(const FloorPlan& plan, World& world);

// One place per room, in order: a ring along its walls; doors join the rings.
void AddRoads(const FloorPlan& plan, RoadMap& roads);

// Puts things where no robot drives and nothing else stands.
class Furnisher {
 public:
  // All must outlive this.
  Furnisher(World& world, Random& random)
      : world_(world), random_(random), placed_vertices_(world.mesh.vertices.size()) {}

  // Claims a circle; false, and nothing happens, if it is taken or within `clearance_m` of a road.
  bool Claim(const Eigen::Vector2d& center, double radius, double clearance_m = 0.95);
  // Adds the mesh's vertices since the last such call as a piece, on the circle claimed last.
  void Place(Furniture::Kind kind);
  // Columns, show cases, statues and partitions in the middle of a room.
  void FurnishMiddle(const Room& room);
  // Pilasters, paintings, benches and cabinets along the walls.
  void FurnishWalls(const Room& room);

 private:
  struct Circle {
    Eigen::Vector2d center;
    double radius;
  };
  void AddExhibit(const Room& room);
  void AddWallPiece(const Eigen::Vector2d& at, double yaw);

  World& world_;
  Random& random_;
  std::vector<Circle> taken_;
  size_t placed_vertices_ = 0;  // Vertices of the mesh that are of no piece to come.
};

}  // namespace isthmus::simulation
