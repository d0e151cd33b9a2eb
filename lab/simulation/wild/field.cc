// A field with one building on it, grass, few trees or none.
#include <algorithm>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

void AddGrass(const Need& need, const Path& path, const HeightAt& ground, Mesh* mesh) {
  Random random = need.season.Draw(0);
  const As grass(mesh, PointClass::kVegetation);
  const double per_m2 = random.Chance(0.4) ? 0 : random.Uniform(0, 4);
  const auto blades = static_cast<int>(std::min(4e5, per_m2 * need.path_length_m * 16));
  const double tall = random.Uniform(0.05, 0.6) * std::min(1.0, need.carrier.height_m);
  for (int i = 0; i < blades; ++i) {
    const double s = random.Uniform(0, path.length());
    const Eigen::Vector3d at = path.Beside(s, random.Uniform(-12, 12));
    const Eigen::Vector3d foot(at.x(), at.y(), ground(at.head<2>()));
    const Eigen::Vector3d side{0.05 * random.Normal(), 0.05 * random.Normal(), 0};
    const Eigen::Vector3d tip{0.1 * random.Normal(), 0.1 * random.Normal(),
                              tall * random.Uniform(0.3, 1)};
    mesh->AddTriangle(foot - side, foot + side, foot + tip, Material::kLeaves);
  }
}

}  // namespace

Scene MakeField(const Need& need, Random& random) {
  Scene scene;
  scene.path = std::make_shared<Path>(
      Path::Wandering({need.path_length_m + 20, random.Uniform(20, 150), random.Uniform(0.2, 3),
                       std::max(3.0, need.carrier.speed_mps * 3)},
                      random));
  const HeightAt ground = Hills({random.Uniform(0, 0.2), random.Uniform(0.01, 0.2)}, random);
  scene.path->Lay(ground, need.carrier.base_m);
  const PathIndex index(*scene.path);
  const double reach = random.Uniform(50, 90);
  AddGround(
      ground, index, {reach, 0.5, 16, 2}, [](const auto&) { return Material::kSoil; }, &scene.mesh);
  const Eigen::Vector3d size{random.Uniform(5, 30), random.Uniform(4, 15), random.Uniform(2.5, 10)};
  const double radius = size.head<2>().norm() / 2 + need.clear_m() + 1;
  for (int tries = 0; tries < 100; ++tries) {
    const Eigen::Vector2d at = index.Anywhere(40, random);
    if (index.Distance(at, 45) < radius || index.Distance(at, 45) >= 45) continue;
    AddHouse({at.x(), at.y(), ground(at)}, size, random.Uniform(0, 6.3), random, &scene.mesh);
    break;
  }
  const int trees = random.Chance(0.4) ? 0 : random.Index(30);
  for (int i = 0; i < trees; ++i) {
    const Eigen::Vector2d at = index.Anywhere(reach, random);
    if (index.Distance(at, 20) < need.clear_m() + 4) continue;
    AddTree({at.x(), at.y(), ground(at)},
            {random.Uniform(3, 14), random.Uniform(0.08, 0.4), 0, need.season.Leaves(200)}, random,
            &scene.mesh);
  }
  AddGrass(need, *scene.path, ground, &scene.mesh);
  return scene;
}

}  // namespace isthmus::simulation::wild
