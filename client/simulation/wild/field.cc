// A field with one building, and a square of people and cars.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/simulation/wild/scenes.h"
#include "client/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

Eigen::Vector2d AnyPlace(const PathIndex& index, double reach_m, Random& random) {
  const double x = random.Uniform(index.min().x() - reach_m, index.max().x() + reach_m);
  return {x, random.Uniform(index.min().y() - reach_m, index.max().y() + reach_m)};
}

// People who walk straight on and come back on the other side of a square around the middle.
std::vector<Motion> Walkers(const PathIndex& index, const HeightAt& ground, int count,
                            Random& random) {
  constexpr double kReach = 25;
  std::vector<Motion> walks;
  const Eigen::Vector2d low = index.min().array() - kReach;
  const Eigen::Vector2d size = (index.max() - index.min()).array() + 2 * kReach;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d from = AnyPlace(index, kReach, random);
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

}  // namespace

Scene MakeField(const Need& need, Random& random) {
  Scene scene;
  scene.path = std::make_shared<Path>(
      Path::Wandering(need.way_m + 20, random.Uniform(20, 150), random.Uniform(0.2, 3),
                      std::max(3.0, need.carrier.speed_mps * 3), random));
  const HeightAt ground = Hills(random.Uniform(0, 0.2), random.Uniform(0.01, 0.2), random);
  scene.path->Lay(ground, need.carrier.base_m);
  const PathIndex index(*scene.path);
  const double reach = random.Uniform(50, 90);
  AddGround(
      ground, index, {reach, 0.5, 16, 2}, [](const auto&) { return Material::kSoil; }, &scene.mesh);
  const Eigen::Vector3d size(random.Uniform(5, 30), random.Uniform(4, 15), random.Uniform(2.5, 10));
  const double radius = size.head<2>().norm() / 2 + need.clear_m() + 1;
  for (int tries = 0; tries < 100; ++tries) {
    const Eigen::Vector2d at = AnyPlace(index, 40, random);
    if (index.Distance(at, 45) < radius || index.Distance(at, 45) >= 45) continue;
    AddHouse({at.x(), at.y(), ground(at)}, size, random.Uniform(0, 6.3), random, &scene.mesh);
    break;
  }
  const int trees = random.Chance(0.4) ? 0 : random.Index(30);
  for (int i = 0; i < trees; ++i) {
    const Eigen::Vector2d at = AnyPlace(index, reach, random);
    if (index.Distance(at, 20) < need.clear_m() + 4) continue;
    AddTree({at.x(), at.y(), ground(at)}, random.Uniform(3, 14), random.Uniform(0.08, 0.4), 0, 200,
            random, &scene.mesh);
  }
  const double grass = random.Chance(0.4) ? 0 : random.Uniform(0, 4);
  const auto blades = static_cast<int>(std::min(4e5, grass * need.way_m * 16));
  const double tall = random.Uniform(0.05, 0.6);
  for (int i = 0; i < blades; ++i) {
    const Eigen::Vector3d at =
        scene.path->Beside(random.Uniform(0, scene.path->length()), random.Uniform(-12, 12));
    const Eigen::Vector3d foot(at.x(), at.y(), ground(at.head<2>()));
    const Eigen::Vector3d side(0.05 * random.Normal(), 0.05 * random.Normal(), 0);
    const double height = tall * random.Uniform(0.3, 1) * std::min(1.0, need.carrier.height_m);
    scene.mesh.AddTriangle(
        foot - side, foot + side,
        foot + Eigen::Vector3d(0.1 * random.Normal(), 0.1 * random.Normal(), height),
        Material::kLeaves);
  }
  return scene;
}

Scene MakeCrowd(const Need& need, Random& random) {
  Scene scene;
  scene.begin_m = 30;
  const bool street = random.Chance(0.5);
  scene.path = std::make_shared<Path>(
      Path::Wandering(need.way_m + 60, random.Uniform(25, 100),
                      street ? random.Uniform(0, 0.4) : random.Uniform(0.5, 2.5),
                      std::max(2.0, need.carrier.speed_mps * 2), random));
  const HeightAt ground = Hills(random.Uniform(0, 0.05), random.Uniform(0, 0.03), random);
  scene.path->Lay(ground, need.carrier.base_m);
  const PathIndex index(*scene.path);
  AddGround(
      ground, index, {60, 1, 1e9, 1}, [](const auto&) { return Material::kAsphalt; }, &scene.mesh);
  // Fronts of houses behind the people, with gaps.
  const double apart = need.clear_m() + random.Uniform(8, 30), present = random.Uniform(0.2, 0.95);
  for (double x = index.min().x() - 50; x < index.max().x() + 50; x += 8) {
    for (double y = index.min().y() - 50; y < index.max().y() + 50; y += 8) {
      const double distance = index.Distance({x, y}, 60);
      const Eigen::Vector3d size(random.Uniform(6, 10), random.Uniform(6, 10),
                                 random.Uniform(4, 15));
      if (random.Unit() > present || distance < apart || distance > apart + 14) continue;
      AddHouse({x, y, ground({x, y})}, size, random.Uniform(-0.05, 0.05), random, &scene.mesh);
    }
  }
  const int things = random.Index(80);
  for (int i = 0; i < things; ++i) {
    const Eigen::Vector2d at = AnyPlace(index, 20, random);
    const double distance = index.Distance(at, 25);
    if (distance < need.clear_m() + 2.5) continue;
    const Eigen::Vector3d foot(at.x(), at.y(), ground(at) - 0.1);
    if (random.Chance(0.3)) {
      AddTree(foot, random.Uniform(3, 9), random.Uniform(0.05, 0.2), 3, 150, random, &scene.mesh);
    } else {
      scene.mesh.AddBox(foot,
                        {random.Uniform(0.2, 3), random.Uniform(0.2, 2), random.Uniform(0.5, 3)},
                        random.Uniform(0, 6.3), Material::kWood);
    }
  }
  const Eigen::Vector2d size = (index.max() - index.min()).array() + 50;
  const double per_m2 = random.Uniform(0.002, 0.05);
  const int people = std::min(350, static_cast<int>(per_m2 * size.x() * size.y()));
  scene.walks = Walkers(index, ground, people, random);
  scene.give_way_m = need.clear_m() + 0.4;
  const int cars = street ? random.Index(40) : 0;
  for (int i = 0; i < cars; ++i) {
    const double speed = random.Uniform(0, 12) * (random.Chance(0.5) ? 1 : -1);
    const double from = random.Uniform(0, scene.path->length());
    const double left = std::copysign(need.clear_m() + random.Uniform(2, 5), -speed);
    scene.cars.push_back([path = scene.path, speed, from, left](double t) {
      const double all = path->length(), s = from + speed * t;
      const double at_s = s - all * std::floor(s / all);
      const Eigen::Vector3d p = path->Beside(at_s, left);
      return Pose::FromXyzRpy(p.x(), p.y(), p.z(), 0, 0,
                              path->At(at_s).yaw + (speed < 0 ? std::numbers::pi : 0));
    });
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
