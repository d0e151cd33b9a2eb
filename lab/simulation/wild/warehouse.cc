// A hall of racks, and a yard of containers: long straight aisles that repeat themselves.
#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct Goods {
  double full;  // Share of the places that hold something.
  Season season;
  uint64_t first;  // Number of a rack's first.
};

// A rack along x: posts, beams, and what stands on them.
void AddRack(const Eigen::Vector2d& middle, const Eigen::Vector2d& size, double height_m,
             Goods goods, Random& random, Mesh* mesh) {
  const As rack(mesh, PointClass::kObject);
  const double bay = random.Uniform(1.8, 3), shelf = random.Uniform(1.2, 2);
  const int bays = std::max(1, static_cast<int>(size.x() / bay));
  const double wide = size.x() / bays;
  const int shelves = std::max(1, static_cast<int>(height_m / shelf));
  for (int i = 0; i <= bays; ++i) {
    for (const double side : {-0.5, 0.0, 0.5}) {
      mesh->AddBox({middle.x() - size.x() / 2 + wide * i, middle.y() + side * (size.y() - 0.1), 0},
                   {0.1, 0.1, height_m}, 0, Material::kMetal);
    }
  }
  for (int level = 0; level < shelves; ++level) {
    const double z = level == 0 ? 0.05 : level * shelf;
    for (const double side : {-0.5, 0.5}) {
      mesh->AddBox({middle.x(), middle.y() + side * (size.y() - 0.1), z}, {size.x(), 0.06, 0.1}, 0,
                   Material::kMetal);
    }
    for (int i = 0; i < bays; ++i) {
      for (const double side : {-0.25, 0.25}) {
        Random thing = goods.season.Draw(goods.first++);
        const double fill = thing.Unit(), tall = thing.Uniform(0.3, 0.85) * shelf;
        const double deep = thing.Uniform(0.5, 0.95) * size.y() / 2;
        const double broad = thing.Uniform(0.4, 0.9) * wide, off = thing.Uniform(-0.1, 0.1);
        if (fill > goods.full) continue;
        mesh->AddBox({middle.x() - size.x() / 2 + wide * (i + 0.5) + off * wide,
                      middle.y() + side * size.y(), z + 0.1},
                     {broad, deep, tall}, 0,
                     thing.Chance(0.8) ? Material::kWood : Material::kPlaster);
      }
    }
  }
}

void AddHall(const Blocks& blocks, double height_m, Random& random, Mesh* mesh) {
  const Eigen::Vector2d total = blocks.Extent();
  const Eigen::Vector2d margin =
      blocks.aisle / 2 + Eigen::Vector2d{random.Uniform(0.5, 6), random.Uniform(0.5, 6)};
  const Eigen::Vector2d size = total + 2 * margin;
  const Eigen::Vector3d middle(total.x() / 2, total.y() / 2, -0.2);
  const As slab_edges(mesh, PointClass::kWall);
  mesh->AddSlab(middle, {size.x(), size.y(), 0.2}, 0, Material::kFloor, PointClass::kGround);
  const double x = size.x() / 2, y = size.y() / 2;
  const Eigen::Vector3d a = middle + Eigen::Vector3d(-x, -y, 0),
                        b = middle + Eigen::Vector3d(x, -y, 0),
                        c = middle + Eigen::Vector3d(x, y, 0),
                        d = middle + Eigen::Vector3d(-x, y, 0);
  AddWall(a, b, height_m, 0.2, Material::kPlaster, mesh);
  AddWall(b, c, height_m, 0.2, Material::kPlaster, mesh);
  AddWall(c, d, height_m, 0.2, Material::kPlaster, mesh);
  AddWall(d, a, height_m, 0.2, Material::kPlaster, mesh);
  mesh->AddSlab(middle + Eigen::Vector3d(0, 0, height_m), {size.x(), size.y(), 0.2}, 0,
                Material::kMetal, PointClass::kCeiling);
  const As truss(mesh, PointClass::kStructure);
  for (double at = -x; at < x; at += 6) {
    mesh->AddBox(middle + Eigen::Vector3d(at, 0, height_m - 0.8), {0.2, size.y(), 0.3}, 0,
                 Material::kMetal);
  }
}

}  // namespace

Scene MakeWarehouse(const Need& need, Random& random) {
  Scene scene;
  Blocks blocks;
  blocks.columns = 1 + random.Index(3);
  blocks.rows = 4 + random.Index(8);
  blocks.size = {random.Uniform(8, 35), random.Uniform(1.6, 2.6)};
  const double narrow = 2 * need.clear_m() + 0.7;
  blocks.aisle = {std::max(narrow, random.Uniform(2.5, 6)),
                  std::max(narrow, random.Uniform(1.8, 4))};
  scene.path = WalkAmong(blocks, need, random);
  const double height = std::max(need.clear_height_m(), random.Uniform(2, 10));
  const double full = random.Uniform(0.3, 1);
  for (int column = 0; column < blocks.columns; ++column) {
    for (int row = 0; row < blocks.rows; ++row) {
      const int number = column * blocks.rows + row;
      const auto rack = static_cast<uint64_t>(number);
      AddRack(blocks.Middle(column, row), blocks.size, height, {full, need.season, rack << 32},
              random, &scene.mesh);
    }
  }
  AddHall(blocks, height + random.Uniform(1.2, 4), random, &scene.mesh);
  return scene;
}

Scene MakeYard(const Need& need, Random& random) {
  Scene scene;
  Blocks blocks;
  blocks.columns = 2 + random.Index(4);
  blocks.rows = 2 + random.Index(6);
  const int long_ones = 1 + random.Index(3), wide_ones = 1 + random.Index(4);
  blocks.size = {12.3 * long_ones, 2.6 * wide_ones};
  const double narrow = 2 * need.clear_m() + 1.5;
  blocks.aisle = {std::max(narrow, random.Uniform(5, 20)), std::max(narrow, random.Uniform(3, 15))};
  scene.path = WalkAmong(blocks, need, random);
  const HeightAt ground = Hills({random.Uniform(0, 0.02), random.Uniform(0, 0.04)}, random);
  scene.path->Lay(ground, need.carrier.base_m);
  const As container(&scene.mesh, PointClass::kObject);
  const double high = random.Uniform(0.5, 4.5), present = random.Uniform(0.4, 1);
  for (int column = 0; column < blocks.columns; ++column) {
    for (int row = 0; row < blocks.rows; ++row) {
      const Eigen::Vector2d corner = blocks.Middle(column, row) - blocks.size / 2;
      for (int i = 0; i < long_ones * wide_ones; ++i) {
        const int x = i % long_ones, y = i / long_ones;
        const Eigen::Vector2d at = corner + Eigen::Vector2d(12.3 * (x + 0.5), 2.6 * (y + 0.5));
        const int place = (column * blocks.rows + row) * long_ones * wide_ones + i;
        Random pile = need.season.Draw(static_cast<uint64_t>(place));
        const int stack =
            pile.Chance(present) ? static_cast<int>(std::ceil(high * pile.Unit())) : 0;
        for (int level = 0; level < stack; ++level) {
          const double off = 0.04 * pile.Normal();
          scene.mesh.AddBox({at.x() + off, at.y(), ground(at) - 0.1 + 2.6 * level},
                            {12.19, 2.44, 2.59}, 0.004 * pile.Normal(), Material::kMetal);
        }
      }
    }
  }
  const PathIndex index(*scene.path);
  AddGround(
      ground, index, {random.Uniform(50, 90), 2, 1e9, 2},
      [](const auto&) { return Material::kAsphalt; }, &scene.mesh);
  return scene;
}

}  // namespace isthmus::simulation::wild
