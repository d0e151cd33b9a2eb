// A plant: vessels, tanks and pipes between walkways.
#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

// A block's ground, in the world.
struct Lot {
  Eigen::Vector2d middle, size;

  // A place of things `margin_m` wide either way.
  Eigen::Vector3d Anywhere(double margin_m, Random& random) const {
    const auto off = [&](double length) {
      const double half = std::max(0.0, length / 2 - margin_m);
      return random.Uniform(-half, half);
    };
    const double x = middle.x() + off(size.x());
    return {x, middle.y() + off(size.y()), 0};
  }
};

void AddVessels(const Lot& lot, Random& random, Mesh* mesh) {
  const As vessel(mesh, PointClass::kObject);
  for (int i = 1 + random.Index(6); i > 0; --i) {
    const double radius = random.Uniform(0.3, std::min(2.5, 0.45 * lot.size.minCoeff()));
    const Eigen::Vector3d at = lot.Anywhere(radius, random);
    if (random.Chance(0.6)) {
      const double tall = random.Uniform(2, 14);
      mesh->AddCylinder(at, radius, tall, Material::kMetal);
    } else {  // Lying on saddles.
      const double half = random.Uniform(0.5, 0.5 * lot.size.x());
      const Eigen::Vector3d axis(std::min(half, lot.size.x() / 2 - 0.1), 0, 0);
      const Eigen::Vector3d lies(lot.middle.x(), at.y(), radius + random.Uniform(0.3, 2));
      AddTube(lies - axis, lies + axis, radius, radius, 20, Material::kMetal, mesh);
      for (const double side : {-0.7, 0.7}) {
        mesh->AddBox({lies.x() + side * axis.x(), lies.y(), 0},
                     {0.3, 1.4 * radius, lies.z() - radius}, 0, Material::kStone);
      }
    }
  }
}

void AddPipes(const Lot& lot, Random& random, Mesh* mesh) {
  const As pipe(mesh, PointClass::kStructure);
  for (int i = random.Index(30); i > 0; --i) {
    const double radius = random.Uniform(0.03, 0.25);
    const Eigen::Vector3d corner = lot.Anywhere(radius, random);
    const Eigen::Vector3d to = lot.Anywhere(radius, random);
    const double low = random.Uniform(0.2, 1.5), high = random.Uniform(1, 6);
    // Along x at one height, up, along y at the other.
    const Eigen::Vector3d a(corner.x(), corner.y(), low), b(to.x(), corner.y(), low),
        c(to.x(), corner.y(), high), d(to.x(), to.y(), high);
    AddTube(a, b, radius, radius, 10, Material::kMetal, mesh);
    AddTube(b, c, radius, radius, 10, Material::kMetal, mesh);
    AddTube(c, d, radius, radius, 10, Material::kMetal, mesh);
  }
}

void AddFrame(const Lot& lot, Random& random, Mesh* mesh) {
  const int bays = 1 + random.Index(3), floors = 1 + random.Index(3);
  const double storey = random.Uniform(2.5, 4.5);
  const Eigen::Vector2d half = lot.size / 2 - Eigen::Vector2d(0.2, 0.2);
  for (int bay = 0; bay <= bays; ++bay) {
    const double x = lot.middle.x() - half.x() + 2 * half.x() * bay / bays;
    for (const double side : {-1.0, 1.0}) {
      As(mesh, PointClass::kPole)
          ->AddBox({x, lot.middle.y() + side * half.y(), 0}, {0.25, 0.25, storey * floors}, 0,
                   Material::kMetal);
    }
  }
  const As beam(mesh, PointClass::kStructure);
  for (int floor = 1; floor <= floors; ++floor) {
    const double z = storey * floor;
    for (const double side : {-1.0, 1.0}) {
      mesh->AddBox({lot.middle.x(), lot.middle.y() + side * half.y(), z}, {2 * half.x(), 0.2, 0.25},
                   0, Material::kMetal);
    }
    if (random.Chance(0.5)) {
      mesh->AddSlab({lot.middle.x(), lot.middle.y(), z}, {2 * half.x(), 2 * half.y(), 0.05}, 0,
                    Material::kMetal, PointClass::kGround);
    }
  }
}

// Pipes above the walkways.
void AddPipeRacks(const Blocks& blocks, double over_m, Random& random, Mesh* mesh) {
  const As pipes(mesh, PointClass::kStructure);
  for (int row = 0; row <= blocks.rows; ++row) {
    if (random.Chance(0.4)) continue;
    const double y = blocks.Pitch().y() * row, z = over_m + random.Uniform(0.3, 3);
    const double x = blocks.Extent().x();
    for (int pipe = 1 + random.Index(7); pipe > 0; --pipe) {
      const double radius = random.Uniform(0.04, 0.2), off = random.Uniform(-1, 1);
      AddTube({-3, y + off, z + radius}, {x + 3, y + off, z + radius}, radius, radius, 10,
              Material::kMetal, mesh);
    }
  }
}

}  // namespace

Scene MakePlant(const Need& need, Random& random) {
  Scene scene;
  Blocks blocks;
  blocks.columns = 2 + random.Index(4);
  blocks.rows = 2 + random.Index(4);
  blocks.size = {random.Uniform(5, 16), random.Uniform(4, 14)};
  const double narrow = 2 * need.clear_m() + 0.8;
  blocks.aisle = {std::max(narrow, random.Uniform(1.5, 6)),
                  std::max(narrow, random.Uniform(1.5, 6))};
  scene.path = WalkAmong(blocks, need, random);
  for (int column = 0; column < blocks.columns; ++column) {
    for (int row = 0; row < blocks.rows; ++row) {
      const Lot lot{blocks.Middle(column, row), blocks.size};
      if (random.Chance(0.8)) AddVessels(lot, random, &scene.mesh);
      if (random.Chance(0.8)) AddPipes(lot, random, &scene.mesh);
      if (random.Chance(0.5)) AddFrame(lot, random, &scene.mesh);
    }
  }
  AddPipeRacks(blocks, need.clear_height_m(), random, &scene.mesh);
  const PathIndex index(*scene.path);
  const HeightAt flat = [](const Eigen::Vector2d&) { return 0.0; };
  AddGround(
      flat, index, {random.Uniform(20, 60), 4, 1e9, 4},
      [](const auto&) { return Material::kFloor; }, &scene.mesh);
  const Eigen::Vector2d extent = blocks.Extent();
  for (int i = random.Index(4); i > 0; --i) {  // Buildings beside it.
    const double x = random.Uniform(0, extent.x());
    const double y = random.Chance(0.5) ? -15 : extent.y() + 15;
    AddHouse({x, y, 0}, {random.Uniform(8, 30), random.Uniform(6, 16), random.Uniform(3, 12)}, 0,
             random, &scene.mesh);
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
