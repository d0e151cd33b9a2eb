// A street or a square full of people and cars, before the fronts of houses.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

// People who walk straight on and come back on the other side of a square around the middle.
std::vector<Motion> Walkers(const PathIndex& index, const HeightAt& ground, int count,
                            Random& random) {
  constexpr double kReach = 25;
  std::vector<Motion> walks;
  const Eigen::Vector2d low = index.min().array() - kReach;
  const Eigen::Vector2d size = (index.max() - index.min()).array() + 2 * kReach;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d from = index.Anywhere(kReach, random);
    const double angle = random.Uniform(0, 2 * std::numbers::pi);
    const double speed = random.Chance(0.3) ? 0 : random.Uniform(0.3, 2);
    const Eigen::Vector2d by = speed * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    walks.push_back([=](double t) {
      Eigen::Vector2d at = from + t * by - low;
      for (int axis = 0; axis < 2; ++axis)
        at[axis] -= size[axis] * std::floor(at[axis] / size[axis]);
      at += low;
      return Pose(Eigen::Vector3d(at.x(), at.y(), ground(at)));
    });
  }
  return walks;
}

void AddFronts(const Need& need, const PathIndex& index, const HeightAt& ground, Random& random,
               Mesh* mesh) {
  const double apart = need.clear_m() + random.Uniform(8, 30), present = random.Uniform(0.2, 0.95);
  for (double x = index.min().x() - 50; x < index.max().x() + 50; x += 8) {
    for (double y = index.min().y() - 50; y < index.max().y() + 50; y += 8) {
      const double distance = index.Distance({x, y}, 60);
      const Eigen::Vector3d size{random.Uniform(6, 10), random.Uniform(6, 10),
                                 random.Uniform(4, 15)};
      if (random.Unit() > present || distance < apart || distance > apart + 14) continue;
      AddHouse({x, y, ground({x, y})}, size, random.Uniform(-0.05, 0.05), random, mesh);
    }
  }
}

void AddThings(const Need& need, const PathIndex& index, const HeightAt& ground, Random& random,
               Mesh* mesh) {
  const int things = random.Index(80);
  for (int i = 0; i < things; ++i) {
    Random thing = need.season.Draw(i);
    const Eigen::Vector2d at = index.Anywhere(20, thing);
    const double distance = index.Distance(at, 25);
    if (distance < need.clear_m() + 2.5) continue;
    const Eigen::Vector3d foot(at.x(), at.y(), ground(at) - 0.1);
    if (thing.Chance(0.3)) {
      const Tree tree{thing.Uniform(3, 9), thing.Uniform(0.05, 0.2), 3, need.season.Leaves(150)};
      AddTree(foot, tree, thing, mesh);
    } else {
      const Eigen::Vector3d box{thing.Uniform(0.2, 3), thing.Uniform(0.2, 2),
                                thing.Uniform(0.5, 3)};
      As(mesh, PointClass::kObject)->AddBox(foot, box, thing.Uniform(0, 6.3), Material::kWood);
    }
  }
}

// Cars in both directions beside the path, over and over.
void AddTraffic(const Need& need, Random& random, Scene* scene) {
  const int cars = random.Index(40);
  for (int i = 0; i < cars; ++i) {
    const double speed = random.Uniform(0, 12) * (random.Chance(0.5) ? 1 : -1);
    const double from = random.Uniform(0, scene->path->length());
    const double left = std::copysign(need.clear_m() + random.Uniform(2, 5), -speed);
    scene->cars.push_back([path = scene->path, speed, from, left](double t) {
      const double all = path->length(), s = from + speed * t;
      const double at_s = s - all * std::floor(s / all);
      const Eigen::Vector3d p = path->Beside(at_s, left);
      return Pose::FromXyzRpy(p.x(), p.y(), p.z(), 0, 0,
                              path->At(at_s).yaw + (speed < 0 ? std::numbers::pi : 0));
    });
  }
}

}  // namespace

Scene MakeCrowd(const Need& need, Random& random) {
  Scene scene;
  scene.begin_m = 30;
  const bool street = random.Chance(0.5);
  scene.path = std::make_shared<Path>(
      Path::Wandering({need.path_length_m + 60, random.Uniform(25, 100),
                       street ? random.Uniform(0, 0.4) : random.Uniform(0.5, 2.5),
                       std::max(2.0, need.carrier.speed_mps * 2)},
                      random));
  const HeightAt ground = Hills({random.Uniform(0, 0.05), random.Uniform(0, 0.03)}, random);
  scene.path->Lay(ground, need.carrier.base_m);
  const PathIndex index(*scene.path);
  AddGround(
      ground, index, {60, 1, 1e9, 1}, [](const auto&) { return Material::kAsphalt; }, &scene.mesh);
  AddFronts(need, index, ground, random, &scene.mesh);
  AddThings(need, index, ground, random, &scene.mesh);
  const Eigen::Vector2d size = (index.max() - index.min()).array() + 50;
  const double per_m2 = random.Uniform(0.002, 0.05);
  const int people = std::min(350, static_cast<int>(per_m2 * size.x() * size.y()));
  scene.walks = Walkers(index, ground, people, random);
  scene.give_way_m = need.clear_m() + 0.4;
  if (street) AddTraffic(need, random, &scene);
  return scene;
}

}  // namespace isthmus::simulation::wild
