// A house of several storeys: along one side a ramp or a flight of stairs from storey to storey,
// each above the other; beside it a passage, and rooms.
#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct House {
  int storeys;
  double storey_m, slab_m = 0.25;
  bool stairs;
  double landing_m, flight_m;        // Along x: landing, flight, landing.
  double well_m, passage_m, room_m;  // Along y.
  std::vector<double> walls;         // Between rooms, x; with both ends.
  double door_m;

  double length() const { return 2 * landing_m + flight_m; }
  double depth() const { return well_m + passage_m + room_m; }
  double floor(int storey) const { return storey * storey_m; }
  double clear_height() const { return storey_m - slab_m; }
  int rooms() const { return static_cast<int>(walls.size()) - 1; }
  double door_x(int room) const { return (walls[room] + walls[room + 1]) / 2; }
};

House Design(const Need& need, Random& random) {
  House house;
  house.storeys = 2 + random.Index(3);
  house.storey_m = std::max(need.clear_height_m() + 0.6, random.Uniform(2.6, 4.2));
  house.stairs = need.climbs() && random.Chance(0.7);
  const double slope = house.stairs ? random.Uniform(0.4, 0.65) : random.Uniform(0.13, 0.2);
  house.flight_m = house.storey_m / slope;
  const double wide = 2 * need.clear_m() + 0.4;
  house.landing_m = std::max(wide, random.Uniform(2, 4));
  house.well_m = std::max(wide, random.Uniform(1.4, 3));
  house.passage_m = std::max(wide, random.Uniform(1.4, 3));
  house.room_m = random.Uniform(4, 10);
  house.door_m = std::max(2 * need.clear_m() + 0.25, random.Uniform(0.9, 2));
  const int rooms = std::max(1, static_cast<int>(house.length() / random.Uniform(4, 9)));
  for (int i = 0; i <= rooms; ++i) house.walls.push_back(house.length() * i / rooms);
  return house;
}

// From one end of a storey to the other by the passage, with a look into some rooms.
void CrossStorey(const House& house, const Need& need, int storey, bool east, Random& random,
                 std::vector<Eigen::Vector3d>* corners) {
  const double z = house.floor(storey), y = house.well_m + house.passage_m / 2;
  const auto end = [&](bool at_east) {
    return at_east ? house.length() - house.landing_m / 2 : house.landing_m / 2;
  };
  corners->push_back({end(!east), y, z});
  for (int i = 0; i < house.rooms(); ++i) {
    const int room = east ? i : house.rooms() - 1 - i;
    const double x = house.door_x(room);
    const double half = (house.walls[room + 1] - house.walls[room]) / 2 - need.clear_m() - 0.4;
    const bool between = x > house.landing_m && x < house.length() - house.landing_m;
    if (random.Chance(0.3) || half < 0.8 || !between) continue;
    const double in = house.well_m + house.passage_m + need.clear_m() + 1;
    const double far = house.depth() - need.clear_m() - random.Uniform(0.6, 1.5);
    const double side = std::min(half, random.Uniform(0.8, 3)) * (east ? 1 : -1);
    corners->push_back({x, y, z});
    for (const auto& at :
         {Eigen::Vector2d(x, in), Eigen::Vector2d(x + side, in), Eigen::Vector2d(x + side, far),
          Eigen::Vector2d(x - side, far), Eigen::Vector2d(x - side, in), Eigen::Vector2d(x, in)}) {
      corners->push_back({at.x(), at.y(), z});
    }
    corners->push_back({x, y, z});
  }
  corners->push_back({end(east), y, z});
}

std::vector<Eigen::Vector3d> Climb(const House& house, const Need& need, Random& random) {
  std::vector<Eigen::Vector3d> corners;
  double path_length = 0;
  int storey = 0;
  bool up = true;
  while (path_length < need.path_length_m + 20) {
    const size_t before = corners.size();
    // Up from the west end to the east end, down from the east end to the west end.
    CrossStorey(house, need, storey, !up, random, &corners);
    if (up ? storey + 1 == house.storeys : storey == 0) {
      up = !up;
    } else {
      const double y = house.well_m / 2, x = house.landing_m;
      const double west = house.floor(up ? storey : storey - 1), east = west + house.storey_m;
      std::vector<Eigen::Vector3d> flight{{x / 2, y, west},
                                          {x - 0.2, y, west},
                                          {x + house.flight_m + 0.2, y, east},
                                          {house.length() - x / 2, y, east}};
      if (!up) std::reverse(flight.begin(), flight.end());
      corners.insert(corners.end(), flight.begin(), flight.end());
      storey += up ? 1 : -1;
    }
    for (size_t i = std::max<size_t>(before, 1); i < corners.size(); ++i) {
      path_length += (corners[i] - corners[i - 1]).norm();
    }
  }
  return corners;
}

void AddFlight(const House& house, int storey, Mesh* mesh) {
  const double z = house.floor(storey), x = house.landing_m, y = house.well_m;
  const As walked_on(mesh, PointClass::kGround);
  const int steps = house.stairs ? static_cast<int>(std::lround(house.storey_m / 0.17)) : 1;
  const double run = house.flight_m / steps, rise = house.storey_m / steps;
  for (int i = 0; i < steps; ++i) {
    const double from = x + i * run, low = z + i * rise;
    if (house.stairs) {
      mesh->AddSlab({from + run / 2, y / 2, low}, {run, y, rise}, 0, Material::kStone,
                    PointClass::kGround);
    } else {
      mesh->AddQuad({from, 0, low}, {from + run, 0, low + rise}, {from + run, y, low + rise},
                    {from, y, low}, Material::kStone);
    }
  }
}

void AddWalls(const House& house, int storey, Random& random, Mesh* mesh) {
  const double z = house.floor(storey), high = house.clear_height(), x = house.length();
  const double y = house.depth(), inner = house.well_m + house.passage_m;
  const auto windows = [&](double length, bool some) {
    std::vector<Opening> openings;
    for (double at = 1; some && at + 2 < length; at += random.Uniform(2.2, 5)) {
      openings.push_back(
          {at, at + random.Uniform(0.8, 2), random.Uniform(0.1, 1), high - 0.4, true});
    }
    return openings;
  };
  const Eigen::Vector3d a(0, 0, z), b(x, 0, z), c(x, y, z), d(0, y, z);
  const double panes = random.Unit();
  for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, d}, {d, a}}) {
    AddWallWithOpenings(from, to, house.storey_m, 0.3,
                        windows((to - from).norm(), random.Chance(panes)), Material::kPlaster,
                        mesh);
  }
  // Between the flight and the passage: a wall or a railing.
  const bool wall = random.Chance(0.5);
  (wall ? AddWall : AddParapet)({house.landing_m, house.well_m, z},
                                {x - house.landing_m, house.well_m, z}, wall ? high : 1.0, 0.1,
                                Material::kPlaster, mesh);
  std::vector<Opening> doors;
  for (int room = 0; room < house.rooms(); ++room) {
    const double at = house.door_x(room);
    doors.push_back({at - house.door_m / 2, at + house.door_m / 2, 0, high - 0.1, false});
  }
  AddWallWithOpenings({0, inner, z}, {x, inner, z}, high, 0.15, doors,
                      random.Chance(0.2) ? Material::kGlass : Material::kPlaster, mesh);
  for (int i = 1; i < house.rooms(); ++i) {
    AddWall({house.walls[i], inner, z}, {house.walls[i], y, z}, high, 0.15, Material::kPlaster,
            mesh);
  }
}

// The floor of a storey, which is the ceiling below: not where the flight comes up.
void AddSlab(const House& house, int storey, Mesh* mesh) {
  const double z = house.floor(storey) - house.slab_m, x = house.length(), y = house.depth();
  const bool whole = storey == 0 || storey == house.storeys;
  const PointClass top = storey == house.storeys ? PointClass::kCeiling : PointClass::kGround;
  const As edges(mesh, PointClass::kWall);
  const auto piece = [&](double x0, double x1, double y0, double y1) {
    mesh->AddSlab({(x0 + x1) / 2, (y0 + y1) / 2, z}, {x1 - x0, y1 - y0, house.slab_m}, 0,
                  Material::kFloor, top);
  };
  piece(0, x, house.well_m, y);
  piece(0, house.landing_m, 0, house.well_m);
  piece(x - house.landing_m, x, 0, house.well_m);
  if (whole) piece(house.landing_m, x - house.landing_m, 0, house.well_m);
}

}  // namespace

Scene MakeHouse(const Need& need, Random& random) {
  Scene scene;
  const House house = Design(need, random);
  scene.path = std::make_shared<Path>(Path::Along(Climb(house, need, random), 0.5));
  for (int storey = 0; storey <= house.storeys; ++storey) {
    AddSlab(house, storey, &scene.mesh);
    if (storey == house.storeys) break;
    AddWalls(house, storey, random, &scene.mesh);
    if (storey + 1 < house.storeys) AddFlight(house, storey, &scene.mesh);
  }
  const PathIndex index(*scene.path);
  const As loose(&scene.mesh, PointClass::kObject);
  const int things = random.Index(25) * house.storeys;
  for (int i = 0; i < things; ++i) {
    Random thing = need.season.Draw(i);
    const double radius = thing.Uniform(0.2, 0.8);
    const double low = house.well_m + house.passage_m;
    const Eigen::Vector2d at{thing.Uniform(radius, house.length() - radius),
                             thing.Uniform(low + radius, house.depth() - radius)};
    const double z = house.floor(thing.Index(house.storeys));
    const Eigen::Vector3d size{thing.Uniform(0.6, 1.4) * radius, thing.Uniform(0.6, 1.4) * radius,
                               thing.Uniform(0.4, 2.2)};
    if (index.Distance(at, 3) < need.clear_m() + radius) continue;
    scene.mesh.AddBox({at.x(), at.y(), z}, size, thing.Uniform(0, 6.3), Material::kWood);
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
