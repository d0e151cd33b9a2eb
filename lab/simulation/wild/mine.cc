// A room-and-pillar mine: pillars of rough rock between a rough roof and an uneven floor.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct Mine {
  int columns, rows;  // Numbers of pillars.
  double pitch_m, opening_m, height_m;
  double dip;  // Slope of the seam, along x.
  double rough_m;
};

// The wall round a solid block, from below the floor to above the roof; its corners are cut. Every
// point stands back from the opening by what the rock says.
void AddPillar(const Eigen::Vector2d& middle, const Eigen::Vector2d& half, const Mine& mine,
               const HeightAt& floor, const Rock& rock, bool outward, Mesh* mesh) {
  const As rock_face(mesh, PointClass::kWall);
  const double around = 4 * (half.x() + half.y());
  const int sides = std::max(12, static_cast<int>(around / 0.7));
  const int layers = std::max(3, static_cast<int>((mine.height_m + 1) / 0.7));
  const auto at = [&](int side, int layer) -> Eigen::Vector3d {
    const double angle = 2 * std::numbers::pi * (side % sides) / sides;
    const double c = std::cos(angle), s = std::sin(angle);
    const double r = std::pow(std::pow(std::abs(c), 6) + std::pow(std::abs(s), 6), -1.0 / 6);
    const Eigen::Vector2d out(r * c * half.x(), r * s * half.y());
    Eigen::Vector3d p(middle.x() + out.x(), middle.y() + out.y(), 0);
    p.z() = floor(p.head<2>()) - 0.5 + (mine.height_m + 1) * layer / layers;
    const Eigen::Vector2d back = (outward ? 1 : -1) * std::abs(rock.At(p)) * out.normalized();
    return p + Eigen::Vector3d(back.x(), back.y(), 0);
  };
  for (int side = 0; side < sides; ++side) {
    for (int layer = 0; layer < layers; ++layer) {
      mesh->AddQuad(at(side, layer), at(side + 1, layer), at(side + 1, layer + 1),
                    at(side, layer + 1), Material::kStone);
    }
  }
}

}  // namespace

Scene MakeMine(const Need& need, Random& random) {
  Scene scene;
  Mine mine;
  mine.opening_m = std::max(2 * need.clear_m() + 2, random.Uniform(3.5, 10));
  mine.pitch_m = mine.opening_m + random.Uniform(4, 22);
  mine.columns = 3 + random.Index(4);
  mine.rows = 3 + random.Index(4);
  mine.height_m = std::max(need.clear_height_m() + 0.6, random.Uniform(2, 6));
  mine.rough_m = random.Uniform(0.05, 0.5);
  mine.dip = random.Chance(0.5) ? 0 : random.Uniform(-0.15, 0.15);
  const HeightAt bumps = Hills({random.Uniform(0, 0.05), random.Uniform(0, 0.12)}, random);
  const HeightAt floor = [=](const Eigen::Vector2d& at) { return bumps(at) + mine.dip * at.x(); };

  const double jitter = std::max(0.0, mine.opening_m / 2 - need.clear_m() - 0.6);
  const auto corners = WalkOnGrid(
      mine.columns + 1, mine.rows + 1, need.path_length_m + 30,
      [&](int column, int row) -> Eigen::Vector3d {
        return {mine.pitch_m * column + random.Uniform(-jitter, jitter),
                mine.pitch_m * row + random.Uniform(-jitter, jitter), 0};
      },
      random);
  scene.path =
      std::make_shared<Path>(Path::Along(corners, std::clamp(mine.opening_m / 2.5, 0.8, 2.5)));
  scene.path->Lay(floor, need.carrier.base_m);

  const Rock rock(random.Uniform(1, 4), mine.rough_m, 3, 0.5, random);
  const Eigen::Vector2d solid = Eigen::Vector2d::Constant((mine.pitch_m - mine.opening_m) / 2);
  for (int column = 0; column < mine.columns; ++column) {
    for (int row = 0; row < mine.rows; ++row) {
      if (random.Chance(0.06)) continue;  // Robbed.
      const Eigen::Vector2d shrunk =
          solid.cwiseProduct(Eigen::Vector2d{random.Uniform(0.7, 1), random.Uniform(0.7, 1)});
      AddPillar(mine.pitch_m * Eigen::Vector2d(column + 0.5, row + 0.5), shrunk, mine, floor, rock,
                false, &scene.mesh);
    }
  }
  const Eigen::Vector2d middle = mine.pitch_m / 2 * Eigen::Vector2d(mine.columns, mine.rows);
  // Around it all; the corners, which are cut, have room enough.
  const Eigen::Vector2d half = 1.13 * (middle.array() + mine.opening_m / 2 + 0.5).matrix();
  AddPillar(middle, half, mine, floor, rock, true, &scene.mesh);
  const PathIndex index(*scene.path);
  GroundCover cover{1e3, 0.5, 15, 1, middle - half, middle + half};
  AddGround(
      floor, index, cover, [](const auto&) { return Material::kSoil; }, &scene.mesh);
  const Rock roof(random.Uniform(2, 8), mine.rough_m, 2, 0.5, random);
  const HeightAt ceiling = [&](const Eigen::Vector2d& at) {
    return floor(at) + mine.height_m + std::abs(roof.At({at.x(), at.y(), 0}));
  };
  cover.surface = PointClass::kCeiling;
  AddGround(
      ceiling, index, cover, [](const auto&) { return Material::kStone; }, &scene.mesh);
  return scene;
}

}  // namespace isthmus::simulation::wild
