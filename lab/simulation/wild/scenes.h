// The kinds of wild worlds. Each draws the way first and puts things where the way is not.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/route.h"
#include "lab/simulation/sensors/mesh.h"
#include "lab/simulation/wild/carrier.h"
#include "lab/simulation/wild/path.h"
#include "lab/simulation/wild/season.h"

namespace isthmus::simulation::wild {

// The needs of the drives that a scene is made for: what suits its carrier suits theirs.
struct Need {
  Carrier carrier;
  double path_length_m = 0;  // At least so long must the path be.
  double seconds = 0;
  Season season;
  int robots = 1;     // So many want a way of their own, where a scene has such.
  bool bare = false;  // Without furniture, where a scene has furniture of its own.

  bool climbs() const { return carrier.gait == Gait::kLegs || carrier.gait == Gait::kHand; }
  // Nothing may stand nearer to the path, seen from above ...
  double clear_m() const { return carrier.base_m / 2 + (carrier.gait == Gait::kCar ? 0.7 : 0.45); }
  // ... or hang lower above it.
  double clear_height_m() const { return carrier.height_m + 0.5; }
};

struct Scene {
  Mesh mesh;
  std::shared_ptr<Path> path;  // Longer than was needed by `begin_m` and what is seen ahead.
  double begin_m = 3;          // Start of the drive on the path.
  // A way of its own for each robot, each as long as the path; empty: all share the path.
  std::vector<std::shared_ptr<Path>> ways;
  double oncoming_left_m = 0;  // The other lane, from the path.
  // Storeys that are alike but for loose things, each so far above the next; the path is on the
  // lowest.
  int storeys = 1;
  double storey_m = 0;
  std::vector<Motion> walks, cars;  // Feet of people, middles of cars, on the ground.
  // People give way: they come no nearer than this to the base.
  double give_way_m = 1;
};

struct Kind {
  std::string name;
  std::vector<Gait> gaits;
  double top_mps;
  Scene (*make)(const Need& need, Random& random);
};

Scene MakeRoad(const Need& need, Random& random);
Scene MakeForest(const Need& need, Random& random);
Scene MakeMine(const Need& need, Random& random);
Scene MakeTunnel(const Need& need, Random& random);
Scene MakeWarehouse(const Need& need, Random& random);
Scene MakeYard(const Need& need, Random& random);
Scene MakeField(const Need& need, Random& random);
Scene MakeHouse(const Need& need, Random& random);
Scene MakePlant(const Need& need, Random& random);
Scene MakeCrowd(const Need& need, Random& random);
Scene MakeHotel(const Need& need, Random& random);
Scene MakeInn(const Need& need, Random& random);
Scene MakeFlat(const Need& need, Random& random);
Scene MakeOffice(const Need& need, Random& random);
Scene MakeStorey(const Need& need, Random& random);
Scene MakeCarPark(const Need& need, Random& random);

// Somebody who walks along a path and back, over and over, from a place on it.
Motion WalkToAndFro(std::shared_ptr<const Path> path, double speed_mps, double from_m);

// Blocks side by side, with aisles between them and around, from the origin on.
struct Blocks {
  int columns = 1, rows = 1;
  Eigen::Vector2d size, aisle;  // Size of a block; width between blocks.

  Eigen::Vector2d Pitch() const { return size + aisle; }
  Eigen::Vector2d Middle(int column, int row) const {
    return Pitch().cwiseProduct(Eigen::Vector2d(column + 0.5, row + 0.5));
  }
  // The extent of all of them with their aisles.
  Eigen::Vector2d Extent() const { return Pitch().cwiseProduct(Eigen::Vector2d(columns, rows)); }
};

// A walk in the aisles.
std::shared_ptr<Path> WalkAmong(const Blocks& blocks, const Need& need, Random& random);

// A walk along the lines of a grid, `columns` x `rows` crossings at `at(column, row)`: long enough,
// never straight back unless there is no other way.
std::vector<Eigen::Vector3d> WalkOnGrid(
    int columns, int rows, double path_length_m,
    const std::function<Eigen::Vector3d(int column, int row)>& at, Random& random);

}  // namespace isthmus::simulation::wild
