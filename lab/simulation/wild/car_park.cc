// A car park: decks above each other, with two aisles between rows of bays and a ramp up.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lab/simulation/wild/furniture.h"
#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kBayM = 2.5, kRowM = 5, kAisleM = 6;

// From south to north: bays, an aisle, bays, the ramp's lane, an aisle, bays. Ramps go up from west
// to east, each above the other; a lane leads across at either end.
struct Park {
  int decks, bays;  // In a row.
  double deck_m, slab_m = 0.3, cross_m, run_m;
  bool roof, closed;
  int bays_per_column;

  double length() const { return 2 * cross_m + bays * kBayM; }
  double depth() const { return 4 * kRowM + 2 * kAisleM; }
  double aisle_y(int aisle) const {
    return aisle == 0 ? kRowM + kAisleM / 2 : depth() - aisle_y(0);
  }
  double ramp_y() const { return 2.5 * kRowM + kAisleM; }
  double cross_x(bool east) const { return east ? length() - cross_m / 2 : cross_m / 2; }
  double z(int deck) const { return deck * deck_m; }
};

Park DesignPark(const Need& need, Random& random) {
  Park park;
  park.decks = 2 + random.Index(2);
  park.deck_m = std::max(need.clear_height_m() + 0.9, random.Uniform(2.7, 3.3));
  park.cross_m = std::max(2 * need.clear_m() + 1.5, random.Uniform(5.5, 7.5));
  park.run_m = park.deck_m / random.Uniform(0.12, 0.17);
  park.bays = static_cast<int>(std::ceil(park.run_m / kBayM)) + random.Index(10);
  park.roof = random.Chance(0.6);
  park.closed = random.Chance(0.4);
  park.bays_per_column = 2 + random.Index(2);
  return park;
}

// A drive without turning back: along the aisles, across at the ends, up and down the ramps.
std::vector<Eigen::Vector3d> DriveAround(const Park& park, double length_m, double aside_m,
                                         Random& random) {
  int deck = random.Index(park.decks), lane = random.Index(2) * 2;  // 0, 2: aisles; 1: the ramp.
  bool east = random.Chance(0.5);
  std::vector<Eigen::Vector3d> corners;
  double length = 0;
  const auto go = [&](double x, double y) {
    const Eigen::Vector3d to(x, y, park.z(deck));
    if (!corners.empty()) length += (corners.back() - to).norm();
    corners.push_back(to);
  };
  while (length < length_m) {
    const double aside = random.Uniform(-aside_m, aside_m);
    const double y = (lane == 1 ? park.ramp_y() : park.aisle_y(lane / 2)) + (lane == 1 ? 0 : aside);
    go(park.cross_x(east), y);
    if (lane == 1) {  // The ramp: up to the east, down to the west.
      const double foot = park.cross_m, top = park.cross_m + park.run_m;
      go(east ? top : foot, y);
      deck += east ? -1 : 1;
      go(east ? foot : top, y);
    }
    east = !east;
    go(park.cross_x(east), y);
    const bool ramp = lane != 1 && (east ? deck > 0 : deck + 1 < park.decks) && random.Chance(0.6);
    lane = ramp ? 1 : lane == 1 ? 2 * random.Index(2) : 2 - lane;
  }
  return corners;
}

void AddDeck(const Park& park, int level, Mesh* mesh) {
  const double x = park.length(), y = park.depth(), low = park.ramp_y() - kRowM / 2;
  const PointClass top = level == park.decks ? PointClass::kCeiling : PointClass::kGround;
  const auto piece = [&](double x0, double x1, double y0, double y1) {
    As(mesh, PointClass::kWall)
        ->AddSlab({(x0 + x1) / 2, (y0 + y1) / 2, park.z(level) - park.slab_m},
                  {x1 - x0, y1 - y0, park.slab_m}, 0, Material::kStone, top);
  };
  if (level == park.decks && !park.roof) return;
  piece(0, x, 0, low);
  piece(0, x, low + kRowM, y);
  const bool hole = level > 0 && level < park.decks;
  piece(0, hole ? park.cross_m : x, low, low + kRowM);
  if (hole) piece(park.cross_m + park.run_m, x, low, low + kRowM);
}

// A ramp with walls of a man's waist beside it, on its deck and around its hole above.
void AddRamp(const Park& park, int deck, Mesh* mesh) {
  const double x0 = park.cross_m, x1 = x0 + park.run_m, half = kRowM / 2, y = park.ramp_y();
  const Eigen::Vector3d foot(x0, y, park.z(deck)), top(x1, y, park.z(deck + 1));
  const Eigen::Vector3d across(0, half, 0), down(0, 0, 0.25), up(0, 0, 0.9);
  As(mesh, PointClass::kGround)
      ->AddQuad(foot - across, top - across, top + across, foot + across, Material::kStone);
  As(mesh, PointClass::kCeiling)
      ->AddQuad(foot - across - down, top - across - down, top + across - down,
                foot + across - down, Material::kStone);
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d out = side * across;
    As(mesh, PointClass::kStructure)
        ->AddQuad(foot + out - down, top + out - down, top + out + up, foot + out + up,
                  Material::kStone);
    const Eigen::Vector3d above(0, side * (half + 0.06), 0);
    AddParapet(Eigen::Vector3d(x0, y, park.z(deck + 1)) + above, top + above, 1, 0.12,
               Material::kStone, mesh);
  }
  if (deck + 2 == park.decks) {  // Nothing goes on from here.
    AddParapet({x0, y - half, park.z(deck + 1)}, {x0, y + half, park.z(deck + 1)}, 1, 0.12,
               Material::kStone, mesh);
  }
}

// Outer walls or parapets, columns, beams, a pipe, a staircase's core.
void AddPillars(const Park& park, int deck, Random& random, Mesh* mesh) {
  const double x = park.length(), y = park.depth(), z = park.z(deck);
  const bool covered = deck + 1 < park.decks || park.roof;
  const double high = park.deck_m - park.slab_m;
  const Eigen::Vector3d a(0, 0, z), b(x, 0, z), c(x, y, z), d(0, y, z);
  for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, d}, {d, a}}) {
    const bool wall = park.closed && covered;
    (wall ? AddWall : AddParapet)(from, to, wall ? high : 1.1, 0.25, Material::kStone, mesh);
  }
  const double every = park.bays_per_column * kBayM;
  for (double at = park.cross_m; covered && at <= x - park.cross_m + 0.01; at += every) {
    for (const double row :
         {0.35, kRowM - 0.4, 2 * kRowM + kAisleM - 0.2, y - kRowM + 0.4, y - 0.35}) {
      As(mesh, PointClass::kPole)->AddBox({at, row, z}, {0.24, 0.5, high}, 0, Material::kStone);
    }
    // Beams, but not above a ramp.
    const double ramp = park.ramp_y() - kRowM / 2, beyond = park.ramp_y() + kRowM / 2;
    const bool gap = deck + 1 < park.decks && at < park.cross_m + park.run_m;
    for (const auto& [from, to] : {std::pair(0.0, gap ? ramp : y), {gap ? beyond : y, y}}) {
      if (from == to) continue;
      As(mesh, PointClass::kStructure)
          ->AddBox({at, (from + to) / 2, z + high - 0.4}, {0.3, to - from, 0.4}, 0,
                   Material::kStone);
    }
  }
  if (covered) {
    const double pipe = random.Uniform(1, kRowM - 1);
    AddTube({0, pipe, z + high - 0.5}, {x, pipe, z + high - 0.5}, 0.08, 0.08, 8, Material::kMetal,
            As(mesh, PointClass::kStructure).mesh());
    As(mesh, PointClass::kWall)
        ->AddBox({park.cross_m + kBayM, y - kRowM / 2, z}, {2 * kBayM - 0.4, kRowM - 0.6, high}, 0,
                 Material::kPlaster);
  }
}

// Cars in a share of the bays, each as its driver left it; things that stand about at the walls.
void AddParkedCars(const Park& park, int deck, const Need& need, double full, Mesh* mesh) {
  const double z = park.z(deck), y = park.depth();
  // Middles of the cars: noses or tails are near the walls, or near the columns before the ramp.
  const double rows[3] = {kRowM / 2 + 0.25, 1.5 * kRowM + kAisleM - 0.25, y - kRowM / 2 - 0.25};
  for (int row = 0; row < 3; ++row) {
    for (int bay = 0; bay < park.bays; ++bay) {
      const int number = (deck * 3 + row) * 1000 + bay;
      Random thing = need.season.Draw(static_cast<uint64_t>(number));
      const double x = park.cross_m + (bay + 0.5) * kBayM + thing.Uniform(-0.12, 0.12);
      const double off = thing.Uniform(-0.1, 0.1), turned = 0.025 * thing.Normal();
      const bool core = row == 2 && bay < 2;
      if (core || !thing.Chance(full)) continue;
      const double nose = thing.Chance(0.7) ? 1 : -1;
      const double yaw = nose * (row == 0 ? -1 : 1) * std::numbers::pi / 2 + turned;
      AddParkedCar({x, rows[row] + off, z}, yaw, thing, mesh);
    }
  }
  for (int i = 0; i < 8; ++i) {
    const int number = 20000 + deck * 100 + i;
    Random thing = need.season.Draw(static_cast<uint64_t>(number));
    const bool east = thing.Chance(0.5);
    const double along = thing.Uniform(0.5, y - 0.5);
    if (thing.Chance(0.4)) continue;
    const Spot spot{{east ? park.length() - 0.5 : 0.5, along, z}, thing.Uniform(0, 6.3)};
    AddCartons(spot, 0.5, thing, mesh);
  }
}

}  // namespace

Scene MakeCarPark(const Need& need, Random& random) {
  Scene scene;
  const Park park = DesignPark(need, random);
  const double round = need.carrier.gait == Gait::kCar ? 2.2 : 0.9;
  const double aside = std::max(0.0, 0.8 * (kAisleM / 2 - need.clear_m() - 0.3));
  const auto way = [&](double length_m) {
    return std::make_shared<Path>(Path::Along(DriveAround(park, length_m, aside, random), round));
  };
  for (int robot = 0; robot < need.robots; ++robot) {
    scene.ways.push_back(way(need.path_length_m + 25));
  }
  scene.path = scene.ways.front();
  const int people = random.Chance(0.4) ? 0 : random.Index(6);
  for (int i = 0; i < people; ++i) {
    const std::shared_ptr<const Path> walk = way(80);
    const double speed = random.Uniform(0.5, 1.5);
    scene.walks.push_back(WalkToAndFro(walk, speed, random.Uniform(0, walk->length())));
  }
  scene.give_way_m = need.clear_m() + 0.3;
  const double full = random.Uniform(0.4, 0.8);
  for (int level = 0; level <= park.decks; ++level) {
    AddDeck(park, level, &scene.mesh);
    if (level == park.decks) break;
    AddPillars(park, level, random, &scene.mesh);
    if (level + 1 < park.decks) AddRamp(park, level, &scene.mesh);
    if (!need.bare) AddParkedCars(park, level, need, full, &scene.mesh);
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
