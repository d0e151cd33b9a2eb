// A hall of racks with an open floor beside them.
#include "lab/simulation/worlds/builders.h"
#include "lab/simulation/worlds/floor_plan.h"

namespace isthmus::simulation {
namespace {

constexpr int kRows = 4, kLevels = 3;
constexpr double kLengthM = 50, kWidthM = 30, kCeilingM = 5;
constexpr double kFirstAisleY = 3, kPitchM = 5.6;  // Aisles and racks, in turn.
constexpr double kWestX = 2.6, kEastX = 35.2, kFarX = 47.6;
constexpr double kShelfM = 1.35, kBayM = 2.3;

// Around each rack, and around both halves of the open floor.
void AddRoads(RoadMap* roads) {
  std::vector<int> west, east, far;
  for (int aisle = 0; aisle <= kRows; ++aisle) {
    const double y = kFirstAisleY + kPitchM * aisle;
    west.push_back(roads->AddNode({kWestX, y}, true));
    east.push_back(roads->AddNode({kEastX, y}, true));
    if (aisle % 2 == 0) far.push_back(roads->AddNode({kFarX, y}, true));
  }
  for (int row = 0; row < kRows; ++row) {
    roads->AddPlace({west[row], east[row], east[row + 1], west[row + 1]});
  }
  for (int half = 0; half < kRows / 2; ++half) {
    roads->AddPlace(
        {east[2 * half], far[half], far[half + 1], east[2 * half + 2], east[2 * half + 1]});
  }
}

// Posts, beams, and goods on a share of the places between them.
void AddRack(const Eigen::Vector2d& middle, const Eigen::Vector2d& size, Random& random,
             World* world) {
  Mesh& mesh = world->mesh;
  const As rack(&mesh, PointClass::kObject);
  const int bays = static_cast<int>(size.x() / kBayM);
  const double west = middle.x() - kBayM * bays / 2, height = kLevels * kShelfM;
  for (int i = 0; i <= bays; ++i) {
    for (const double side : {-0.5, 0.0, 0.5}) {
      mesh.AddBox({west + kBayM * i, middle.y() + side * (size.y() - 0.1), 0}, {0.1, 0.1, height},
                  0, Material::kMetal);
    }
  }
  for (int level = 0; level < kLevels; ++level) {
    const double z = level * kShelfM;
    for (const double side : {-0.5, 0.5}) {
      mesh.AddBox({middle.x(), middle.y() + side * (size.y() - 0.1), z}, {kBayM * bays, 0.06, 0.1},
                  0, Material::kMetal);
    }
    for (int i = 0; i < 2 * bays; ++i) {
      const int bay = i / 2, side = i % 2;
      const Eigen::Vector3d base(west + kBayM * (bay + 0.5),
                                 middle.y() + (side - 0.5) * size.y() / 2, z + 0.1);
      const Eigen::Vector3d goods(random.Uniform(0.8, 1.9), random.Uniform(0.6, 0.85),
                                  random.Uniform(0.4, 1.0));
      if (random.Chance(0.3)) {
        world->furniture.empty_shelves.push_back(base);
        continue;
      }
      const size_t first = mesh.vertices.size();
      mesh.AddBox(base, goods, 0, random.Chance(0.8) ? Material::kWood : Material::kPlaster);
      world->furniture.pieces.push_back(
          {Furniture::Kind::kOnShelf, base, goods.norm() / 2, first, mesh.vertices.size() - first});
    }
  }
}

// Pallets, some of them two side by side.
void AddPallets(Random& random, World* world) {
  const Furniture::Floor floor{{kEastX + 0.8, 0.3}, {kLengthM - 0.3, kWidthM - 0.3}};
  world->furniture.floors.push_back(floor);
  Furnisher furnisher(*world, random);
  const As pallet(&world->mesh, PointClass::kObject);
  for (int i = 0; i < 120; ++i) {
    const Eigen::Vector2d at(random.Uniform(floor.min.x(), floor.max.x()),
                             random.Uniform(floor.min.y() + 1, floor.max.y() - 1));
    const Eigen::Vector3d size(random.Chance(0.3) ? 2.5 : 1.2, 0.8, random.Uniform(0.35, 1.8));
    const double yaw = random.Uniform(-0.1, 0.1);
    if (!furnisher.Claim(at, size.head<2>().norm() / 2)) continue;
    world->mesh.AddBox({at.x(), at.y(), 0}, size, yaw, Material::kWood);
    furnisher.Place(Furniture::Kind::kOnFloor);
  }
}

}  // namespace

World MakeWarehouse(uint64_t seed) {
  World world;
  Random random(seed, 1, 0);
  FloorPlan plan;
  Room& hall = plan.rooms.emplace_back();
  hall.min = {0, 0};
  hall.max = {kLengthM, kWidthM};
  hall.ceiling_m = kCeilingM;
  plan.walls = {{{0, 0}, {kLengthM, 0}},
                {{0, kWidthM}, {kLengthM, kWidthM}},
                {{0, 0}, {0, kWidthM}},
                {{kLengthM, 0}, {kLengthM, kWidthM}}};
  BuildFloorPlan(plan, world);
  AddRoads(&world.roads);
  const double length = random.Uniform(23, 29), depth = random.Uniform(1.9, 2.3);
  for (int row = 0; row < kRows; ++row) {
    AddRack({(kWestX + kEastX) / 2, kFirstAisleY + kPitchM * (row + 0.5)}, {length, depth}, random,
            &world);
  }
  AddPallets(random, &world);
  return world;
}

}  // namespace isthmus::simulation
