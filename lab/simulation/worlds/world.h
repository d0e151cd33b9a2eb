// Procedural worlds for simulated robots.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/simulation/sensors/mesh.h"
#include "lab/simulation/worlds/road_map.h"

namespace isthmus::simulation {

// Height of the ground: a sum of plane waves amplitude * sin(kx x + ky y + phase). Flat if empty.
struct Ground {
  struct Wave {
    double kx = 0, ky = 0, phase = 0, amplitude = 0;
  };
  std::vector<Wave> waves;

  double Height(double x, double y) const;
};

// The pieces that stand in a world, and other places where they could stand. Value type.
struct Furniture {
  enum class Kind { kFixed, kOnFloor, kOnShelf };
  // Its vertices in the mesh follow each other; no triangle has others too.
  struct Piece {
    Kind kind = Kind::kFixed;
    Eigen::Vector3d base;  // The middle of its foot, seen from above.
    double radius = 0;     // Circle around it, seen from above.
    size_t first_vertex = 0, vertices = 0;
  };
  struct Floor {
    Eigen::Vector2d min, max;
  };
  std::vector<Piece> pieces;
  std::vector<Floor> floors;
  std::vector<Eigen::Vector3d> empty_shelves;  // Places that hold any piece of kOnShelf.
};

// World frame: z up, origin at a corner, metres. Value type; read-only use is thread safe.
struct World {
  std::string name;
  Mesh mesh;
  Furniture furniture;  // In museum and warehouse.
  Ground ground;
  RoadMap roads;
  // Places robot i tours, taken in turn; empty: chosen by the time there is (see MakeRoutes).
  std::vector<std::vector<int>> fixed_tours;
  double sensor_height_m = 0.8;
  double max_speed_mps = 1.2;
  bool has_streets = false;  // Cars may drive along the stretches.
  double lane_m = 0.25;      // Most distance of a robot from the middle of a stretch.
  double overlap_cell_m =
      0.5;  // Size of surface that counts as one when robots' views are compared.
};

// Makes a world. The same name and seed give the same world on every machine; another seed gives
// another plan of the same kind.
//   museum        A building of about 60 x 40 m on one floor: rooms and halls of 4 to 5 m height
//                 joined by doorways, with columns, show cases, statues, partitions and paintings.
//   warehouse     A hall of 50 x 30 m: rows of racks with goods on their shelves, and an open floor
//                 with pallets.
//   campus        About 260 x 260 m outdoors: streets, buildings of L, T, U and other footprints,
//                 trees, lamp posts, parked cars, fences, gently uneven ground.
//   campus_wide   The same, about 550 x 550 m.
//   corridor      Two lobbies joined by 70 m of bare corridor, along which nothing but the floor,
//                 the ceiling and two walls can be measured.
//   twins         Two identical closed rooms, far apart. Robots 0, 2, ... drive in one of them,
//                 robots 1, 3, ... in the other: every merge of the two is wrong.
//   twins_large   The same with halls of 30 x 22 m: much to agree on, and every merge is wrong.
//   twins_wings   These halls with an open door each, at the same place, to a wing of its own that
//                 its robots visit too; the wings differ. Every merge is wrong, and it shows.
//   twins_joined  The same two rooms with an open door each to one shared hall that every robot
//                 visits too: there is a right merge, and a tempting wrong one.
// InvalidArgument, listing the names, for any other name.
absl::StatusOr<World> MakeWorld(const std::string& name, uint64_t seed);

// The names above, in that order.
std::vector<std::string> WorldNames();

}  // namespace isthmus::simulation
