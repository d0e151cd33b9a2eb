#include "lab/simulation/wild/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::simulation::wild {
namespace {

Eigen::Vector3d Level(double angle) { return {std::cos(angle), std::sin(angle), 0}; }

void AddUpright(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
                double thickness_m, Material material, Mesh* mesh) {
  const Eigen::Vector3d by = to - from;
  mesh->AddBox((from + to) / 2, {by.head<2>().norm(), thickness_m, height_m},
               std::atan2(by.y(), by.x()), material);
}

}  // namespace

void AddTube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_from,
             double radius_to, int sides, Material material, Mesh* mesh) {
  const Eigen::Vector3d axis = (to - from).normalized();
  const Eigen::Vector3d any =
      std::abs(axis.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d u = axis.cross(any).normalized(), v = axis.cross(u);
  const auto rim = [&](int i) -> Eigen::Vector3d {
    const double angle = (2 * std::numbers::pi) * i / sides;
    return std::cos(angle) * u + std::sin(angle) * v;
  };
  for (int i = 0; i < sides; ++i) {
    const Eigen::Vector3d a = rim(i), b = rim(i + 1);
    mesh->AddQuad(from + radius_from * a, from + radius_from * b, to + radius_to * b,
                  to + radius_to * a, material);
  }
}

void AddFoliage(const Eigen::Vector3d& center, const Eigen::Vector3d& radii, int count,
                double leaf_m, Random& random, Mesh* mesh) {
  const As leaves(mesh, PointClass::kVegetation);
  const auto ball = [&random] {
    const double x = random.Normal(), y = random.Normal();
    return Eigen::Vector3d(x, y, random.Normal());
  };
  for (int i = 0; i < count; ++i) {
    const double r = std::cbrt(random.Unit());
    const Eigen::Vector3d at = center + r * ball().normalized().cwiseProduct(radii);
    const Eigen::Vector3d a = at + leaf_m / 2 * ball(), b = at + leaf_m / 2 * ball();
    mesh->AddTriangle(a, b, at + leaf_m / 2 * ball(), Material::kLeaves);
  }
}

void AddTree(const Eigen::Vector3d& foot, const Tree& tree, Random& random, Mesh* mesh) {
  const double height_m = tree.height_m, bare_m = tree.bare_m;
  const double lean = 0.06 * random.Normal();
  const Eigen::Vector3d top = foot + Eigen::Vector3d(0, 0, height_m) +
                              lean * height_m * Level(random.Uniform(0, (2 * std::numbers::pi)));
  const Eigen::Vector3d root = foot - Eigen::Vector3d(0, 0, 0.5);
  AddTube(root, top, tree.radius_m, tree.radius_m * 0.35, 10, Material::kWood,
          As(mesh, PointClass::kPole).mesh());
  const As crown(mesh, PointClass::kVegetation);
  const int boughs = random.Index(5);
  const double crown_from = std::max(random.Uniform(0.15, 0.6), bare_m / height_m);
  for (int i = 0; i < boughs; ++i) {
    const double up = std::max(random.Uniform(crown_from / 2, 1), (bare_m + 0.4) / height_m);
    if (up > 1) continue;
    const Eigen::Vector3d at = foot + up * (top - foot);
    const double out = random.Uniform(0.5, 2.5), to = random.Uniform(0, (2 * std::numbers::pi));
    const Eigen::Vector3d tip =
        at + out * Level(to) + Eigen::Vector3d(0, 0, random.Uniform(-0.3, 1));
    AddTube(at, tip, 0.05, 0.02, 4, Material::kWood, mesh);
  }
  const double wide = height_m * random.Uniform(0.1, 0.25);
  if (crown_from >= 1) return;
  const Eigen::Vector3d middle = foot + (crown_from + 1) / 2 * (top - foot);
  Random foliage(random.Next());  // However many leaves there are, the next tree is the same.
  AddFoliage(middle, {wide, wide, height_m * (1 - crown_from) / 2}, tree.leaves,
             foliage.Uniform(0.1, 0.3), foliage, mesh);
}

void AddBush(const Eigen::Vector3d& foot, double radius_m, int leaves, Random& random, Mesh* mesh) {
  const As bush(mesh, PointClass::kVegetation);
  const double tall = radius_m * random.Uniform(0.6, 1.6);
  AddFoliage(foot + Eigen::Vector3d(0, 0, tall * 0.8), {radius_m, radius_m, tall}, leaves,
             random.Uniform(0.06, 0.16), random, mesh);
  for (int i = random.Index(4); i > 0; --i) {
    AddTube(foot,
            foot + tall * (0.5 * Level(random.Uniform(0, (2 * std::numbers::pi))) +
                           Eigen::Vector3d::UnitZ()),
            0.03, 0.01, 4, Material::kWood, mesh);
  }
}

void AddBoulder(const Eigen::Vector3d& center, double radius_m, Random& random, Mesh* mesh) {
  constexpr int kRings = 5, kSides = 8;
  const As boulder(mesh, PointClass::kObject);
  const Rock rock(radius_m, 0.35 * radius_m, 2, 0.5, random);
  const auto at = [&](int ring, int side) -> Eigen::Vector3d {
    const double up = std::numbers::pi * ring / kRings;
    const Eigen::Vector3d out =
        std::sin(up) * Level((2 * std::numbers::pi) * (side % kSides) / kSides) -
        std::cos(up) * Eigen::Vector3d::UnitZ();
    return center + (radius_m + rock.At(center + radius_m * out)) * out;
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int side = 0; side < kSides; ++side) {
      mesh->AddQuad(at(ring, side), at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side),
                    Material::kStone);
    }
  }
}

void AddWall(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
             double thickness_m, Material material, Mesh* mesh) {
  const As wall(mesh, PointClass::kWall);
  AddUpright(from, to, height_m, thickness_m, material, mesh);
}

void AddParapet(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
                double thickness_m, Material material, Mesh* mesh) {
  const As parapet(mesh, PointClass::kStructure);
  AddUpright(from, to, height_m, thickness_m, material, mesh);
}

void AddWallWithOpenings(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
                         double thickness_m, const std::vector<Opening>& openings,
                         Material material, Mesh* mesh) {
  const Eigen::Vector3d along = (to - from).normalized(), up = Eigen::Vector3d::UnitZ();
  const As wall(mesh, PointClass::kWall);
  const auto piece = [&](double begin, double end, double bottom, double top) {
    if (end - begin < 1e-3 || top - bottom < 1e-3) return;
    AddWall(from + begin * along + bottom * up, from + end * along + bottom * up, top - bottom,
            thickness_m, material, mesh);
  };
  double done = 0;
  for (const Opening& opening : openings) {  // In order along the wall.
    piece(done, opening.from_m, 0, height_m);
    piece(opening.from_m, opening.to_m, 0, opening.bottom_m);
    piece(opening.from_m, opening.to_m, opening.top_m, height_m);
    if (opening.glazed) {
      const Eigen::Vector3d a = from + opening.from_m * along, b = from + opening.to_m * along;
      mesh->AddQuad(a + opening.bottom_m * up, b + opening.bottom_m * up, b + opening.top_m * up,
                    a + opening.top_m * up, Material::kGlass);
    }
    done = opening.to_m;
  }
  piece(done, (to - from).norm(), 0, height_m);
}

void AddBand(const Path& path, const Band& band, const HeightAt& ground, Mesh* mesh) {
  constexpr double kStep = 1;
  const bool kerb = band.material == Material::kStone;
  const As as(mesh, kerb ? PointClass::kGround : PointClass::kStructure);
  const auto foot = [&](double s) {
    Eigen::Vector3d at = path.Beside(s, band.left_m);
    if (ground) at.z() = ground(at.head<2>());
    return at;
  };
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (double s = band.s_from; s < band.s_to; s += kStep) {
    const Eigen::Vector3d a = foot(s), b = foot(std::min(s + kStep, band.s_to));
    mesh->AddQuad(a + band.bottom_m * up, b + band.bottom_m * up, b + band.top_m * up,
                  a + band.top_m * up, band.material);
  }
}

void AddHouse(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw, Random& random,
              Mesh* mesh) {
  const Eigen::Vector3d deep(0, 0, 2);  // On a slope its walls go down into the ground.
  const As wall(mesh, PointClass::kWall);
  mesh->AddSlab(base - deep, size + deep, yaw,
                random.Chance(0.5) ? Material::kPlaster : Material::kStone, PointClass::kCeiling);
  const Eigen::Vector3d x = Level(yaw), y = Level(yaw + (2 * std::numbers::pi) / 4);
  const double eaves = random.Uniform(0.2, 0.8), gable = random.Uniform(0, 0.5) * size.y();
  const Eigen::Vector3d along = (size.x() / 2 + eaves) * x, out = (size.y() / 2 + eaves) * y;
  const Eigen::Vector3d top = base + Eigen::Vector3d(0, 0, size.z());
  const Eigen::Vector3d ridge = top + Eigen::Vector3d(0, 0, gable + 0.05);
  for (const double side : {-1.0, 1.0}) {
    As(mesh, PointClass::kCeiling)
        ->AddQuad(top - along + side * out, top + along + side * out, ridge + along, ridge - along,
                  Material::kStone);
    // Windows stand out a little, so that they are what is hit.
    for (double at = -size.x() / 2 + 1; at + 1.5 < size.x() / 2; at += random.Uniform(2, 4)) {
      for (double z = 0.9; z + 1.4 < size.z(); z += 3) {
        if (random.Chance(0.3)) continue;
        const Eigen::Vector3d low =
            base + (at * x + side * (size.y() / 2 + 0.04) * y) + Eigen::Vector3d(0, 0, z);
        const Eigen::Vector3d up(0, 0, 1.3);
        mesh->AddQuad(low, low + 1.1 * x, low + 1.1 * x + up, low + up, Material::kGlass);
      }
    }
  }
}

}  // namespace isthmus::simulation::wild
