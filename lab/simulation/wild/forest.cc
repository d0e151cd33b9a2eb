// A forest: trunks, bushes, undergrowth, rocks on rolling ground.
#include <cmath>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct Woods {
  const PathIndex& index;
  const HeightAt& ground;
  double reach_m, clear_m, clear_height_m;
  Season season;
};

// Calls `put` with the foot of each of so many things per square metre, none on the path.
template <typename Put>
void Scatter(const Woods& woods, double per_m2, double reach_m, double clear_m, Random& random,
             Put put) {
  const Eigen::Vector2d low = woods.index.min().array() - reach_m;
  const Eigen::Vector2d size = woods.index.max() - woods.index.min();
  const Eigen::Vector2d all = size.array() + 2 * reach_m;
  const auto count = static_cast<int>(per_m2 * all.x() * all.y());
  for (int i = 0; i < count; ++i) {
    const double x = low.x() + all.x() * random.Unit(), y = low.y() + all.y() * random.Unit();
    const double distance = woods.index.Distance({x, y}, reach_m);
    if (distance >= reach_m || distance < clear_m) continue;
    put(Eigen::Vector3d(x, y, woods.ground({x, y})), distance);
  }
}

void AddTrees(const Woods& woods, Random& random, Mesh* mesh) {
  const double per_m2 = std::pow(10.0, random.Uniform(-1.8, -0.7));
  const double tall = random.Uniform(5, 22), thick = random.Uniform(0.05, 0.3);
  const int leaves = woods.season.Leaves(random.Index(250));
  Scatter(woods, per_m2, woods.reach_m, woods.clear_m + 0.6, random,
          [&](const Eigen::Vector3d& foot, double distance) {
            const double size = random.Uniform(0.3, 1.2), radius = thick * random.Uniform(0.4, 1.6);
            if (distance < woods.clear_m + 0.6 + radius + 0.06 * tall) return;
            const bool overhangs = distance < woods.clear_m + 0.3 * tall + 2.5;
            AddTree(foot,
                    {tall * size, radius, overhangs ? woods.clear_height_m + 0.6 : 0,
                     distance < 25 ? leaves : leaves / 3},
                    random, mesh);
          });
}

void AddUndergrowth(const Woods& woods, Mesh* mesh) {
  Random random = woods.season.Draw(0);
  const double bushes = random.Chance(0.3) ? 0 : random.Uniform(0, 0.08);
  Scatter(woods, bushes, woods.reach_m * 0.6, woods.clear_m, random,
          [&](const Eigen::Vector3d& foot, double distance) {
            const double radius = random.Uniform(0.2, 1.2);
            if (distance < woods.clear_m + 1.6 * radius) return;
            Random bush(random.Next());  // Draws more for more leaves.
            AddBush(foot, radius, woods.season.Leaves(20 + static_cast<int>(100 * radius)), bush,
                    mesh);
          });
  const double grass = random.Chance(0.4) ? 0 : random.Uniform(0, 3);
  const double tall = random.Uniform(0.1, 0.7);
  const As blades(mesh, PointClass::kVegetation);
  Scatter(woods, grass, 14, 0.3, random, [&](const Eigen::Vector3d& foot, double distance) {
    const double height = tall * random.Uniform(0.3, 1) * (distance < woods.clear_m ? 0.4 : 1);
    const Eigen::Vector3d side{0.04 * random.Normal(), 0.04 * random.Normal(), 0};
    const Eigen::Vector3d tip{0.1 * random.Normal(), 0.1 * random.Normal(), height};
    mesh->AddTriangle(foot - side, foot + side, foot + tip, Material::kLeaves);
  });
}

void AddDebris(const Woods& woods, Random& random, Mesh* mesh) {
  Scatter(woods, random.Uniform(0, 0.01), woods.reach_m * 0.6, woods.clear_m, random,
          [&](const Eigen::Vector3d& foot, double distance) {
            const double small = random.Unit(), radius = 0.2 + 0.8 * small * random.Unit();
            if (distance > woods.clear_m + 1.5 * radius) AddBoulder(foot, radius, random, mesh);
          });
  Scatter(woods, random.Uniform(0, 0.005), woods.reach_m * 0.6, woods.clear_m, random,
          [&](const Eigen::Vector3d& foot, double distance) {
            const double half = random.Uniform(1, 5), angle = random.Uniform(0, 6.3);
            if (distance < woods.clear_m + half) return;
            Eigen::Vector3d by = half * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
            Eigen::Vector3d a = foot - by, b = foot + by;
            for (Eigen::Vector3d* end : {&a, &b}) end->z() = woods.ground(end->head<2>()) + 0.15;
            AddTube(a, b, 0.2, 0.12, 8, Material::kWood, As(mesh, PointClass::kObject).mesh());
          });
}

}  // namespace

Scene MakeForest(const Need& need, Random& random) {
  Scene scene;
  scene.path =
      std::make_shared<Path>(Path::Wandering({need.path_length_m + 12, random.Uniform(15, 80),
                                              random.Uniform(0.5, 2.2), random.Uniform(2, 10)},
                                             random));
  const HeightAt ground = Hills({random.Uniform(0, 0.2), random.Uniform(0.05, 0.35)}, random);
  scene.path->Lay(ground, need.carrier.base_m);
  const PathIndex index(*scene.path);
  const Woods woods{
      index, ground, random.Uniform(30, 55), need.clear_m(), need.clear_height_m(), need.season};
  AddGround(
      ground, index, {woods.reach_m, 0.5, 16, 1}, [](const auto&) { return Material::kSoil; },
      &scene.mesh);
  AddTrees(woods, random, &scene.mesh);
  AddUndergrowth(woods, &scene.mesh);
  AddDebris(woods, random, &scene.mesh);
  return scene;
}

}  // namespace isthmus::simulation::wild
