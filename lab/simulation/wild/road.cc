// An open road through hills: guard rails, few poles, little else.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct Road {
  std::shared_ptr<Path> path;
  std::unique_ptr<PathIndex> index;
  double half_m = 4;   // Half the asphalt's width; the path is its lane's middle,
  double lane_m = -2;  // this far left of the road's middle.
  HeightAt ground;

  double Left(double side) const { return side * half_m - lane_m; }  // Its edges, from the path.
};

Road Survey(const Need& need, Random& random) {
  Road road;
  const double speed = need.carrier.speed_mps;
  const double radius = std::max(25.0, speed * random.Uniform(4, 15));
  const double swing = random.Uniform(0.05, 0.9);
  road.path = std::make_shared<Path>(
      Path::Wandering({need.path_length_m + 120, random.Uniform(60, 300), swing, radius}, random));
  road.half_m = random.Uniform(2.8, 7);
  road.lane_m = -road.half_m * random.Uniform(0.3, 0.5);
  const HeightAt hills = Hills({random.Uniform(0, 0.2), random.Uniform(0.02, 0.5)}, random);
  // The ground that the road is cut into: the hills without small bumps.
  const auto graded = std::make_shared<Path>(*road.path);
  graded->Lay(hills, 12);
  const auto index = std::make_shared<PathIndex>(*graded);
  const double verge = road.half_m + std::abs(road.lane_m) + random.Uniform(0.5, 2);
  const double slope = random.Uniform(4, 15);
  const auto worn = std::make_shared<Rock>(3, random.Uniform(0, 0.02), 2, 0.5, random);
  road.ground = [=](const Eigen::Vector2d& at) {
    const auto near = index->Nearest(at, verge + slope);
    const double wild = near.distance_m < verge ? 0 : hills(at);
    if (near.distance_m >= verge + slope) return wild;
    const double flat = graded->At(near.s).position.z() + worn->At({at.x(), at.y(), 0});
    const double f = std::max(0.0, (near.distance_m - verge) / slope);
    return flat + f * f * (3 - 2 * f) * (wild - flat);
  };
  road.path->Lay(road.ground, need.carrier.base_m);
  road.index = std::make_unique<PathIndex>(*road.path);
  return road;
}

// Stretches of guard rail with posts, on one side.
void AddRails(const Road& road, double side, Random& random, Mesh* mesh) {
  const double left = road.Left(side) + side * random.Uniform(0.3, 1.5);
  const double post_m = random.Uniform(1.3, 4), density = random.Uniform(0.2, 1);
  for (double s = 0; s < road.path->length();) {
    const double length = random.Uniform(20, 300);
    if (random.Chance(density)) {
      const double end = std::min(s + length, road.path->length());
      AddBand(*road.path, {s, end, left, 0.45, 0.75, Material::kMetal}, road.ground, mesh);
      for (double at = s; at < end; at += post_m) {
        Eigen::Vector3d foot = road.path->Beside(at, left + 0.1 * side);
        foot.z() = road.ground(foot.head<2>()) - 0.2;
        As(mesh, PointClass::kStructure)
            ->AddBox(foot, {0.1, 0.1, 0.95}, road.path->At(at).yaw, Material::kMetal);
      }
    }
    s += length;
  }
}

void AddPoles(const Road& road, Random& random, Mesh* mesh) {
  const double every = random.Uniform(30, 200);
  const As pole(mesh, PointClass::kPole);
  for (double s = random.Uniform(0, every); s < road.path->length();
       s += every * random.Uniform(0.7, 1.3)) {
    const double side = random.Chance(0.7) ? -1 : 1;
    Eigen::Vector3d foot = road.path->Beside(s, road.Left(side) + side * random.Uniform(0.8, 4));
    foot.z() = road.ground(foot.head<2>()) - 0.3;
    const double tall = random.Chance(0.5) ? random.Uniform(1, 3) : random.Uniform(4, 10);
    const Eigen::Vector3d top = foot + Eigen::Vector3d(0, 0, tall);
    AddTube(foot, top, random.Uniform(0.04, 0.15), 0.04, 8, Material::kMetal, mesh);
    if (tall < 3.1 && random.Chance(0.7)) {  // A sign.
      const double wide = random.Uniform(0.3, 1.2);
      mesh->AddBox(top, {0.02, wide, wide}, road.path->At(s).yaw, Material::kRetro);
    }
  }
}

// Trees, bushes and the odd house off the road.
void AddCountry(const Road& road, double reach_m, const Season& season, Random& random,
                Mesh* mesh) {
  const double edge = road.half_m + std::abs(road.lane_m) + 2;
  const Eigen::Vector2d size = road.index->max() - road.index->min();
  const double area = road.path->length() * 2 * reach_m;
  const double share = (size.x() + 2 * reach_m) * (size.y() + 2 * reach_m) / area;
  const double density = random.Chance(0.5) ? random.Uniform(0, 0.0005) : random.Uniform(0, 0.004);
  const auto count = static_cast<int>(area * share * density);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d at = road.index->Anywhere(reach_m, random);
    const double distance = road.index->Distance(at, reach_m);
    const double which = random.Unit();
    if (distance >= reach_m || distance < edge) continue;
    const Eigen::Vector3d foot(at.x(), at.y(), road.ground(at));
    if (which < 0.45) {
      Random bush(random.Next());  // Draws more for more leaves.
      AddBush(foot, bush.Uniform(0.3, 1.2), season.Leaves(80), bush, mesh);
    } else if (which < 0.97 && distance > edge + 4) {
      const Tree tree{random.Uniform(3, 15), random.Uniform(0.06, 0.3), 0, season.Leaves(150)};
      AddTree(foot, tree, random, mesh);
    } else if (distance > edge + 12) {
      const Eigen::Vector3d house{random.Uniform(6, 16), random.Uniform(5, 10),
                                  random.Uniform(2.5, 8)};
      AddHouse(foot, house, random.Uniform(0, 6.3), random, mesh);
    }
  }
}

// A car on a lane; `s_at` says how far along it is.
Motion CarOn(std::shared_ptr<const Path> path, double left_m, bool oncoming,
             std::function<double(double)> s_at) {
  return [=](double t) {
    const double s = s_at(t);
    if (s < 0 || s > path->length()) return Pose(Eigen::Vector3d(0, 0, -1000));  // Out of sight.
    const Path::Sample at = path->At(s);
    const Eigen::Vector3d p = path->Beside(s, left_m);
    return Pose::FromXyzRpy(p.x(), p.y(), p.z(), 0, 0, at.yaw + (oncoming ? std::numbers::pi : 0));
  };
}

}  // namespace

Scene MakeRoad(const Need& need, Random& random) {
  Scene scene;
  const Road road = Survey(need, random);
  scene.path = road.path;
  scene.begin_m = 50;
  const double reach = random.Uniform(60, 100);
  const double paved = road.half_m + 0.1;
  const auto material = [&](const Eigen::Vector2d& at) {
    const auto near = road.index->Nearest(at, 20);
    if (near.distance_m >= 20) return Material::kSoil;
    const Path::Sample on = road.path->At(near.s);
    const Eigen::Vector2d by = at - on.position.head<2>();
    const double left = -std::sin(on.yaw) * by.x() + std::cos(on.yaw) * by.y();
    return std::abs(left + road.lane_m) < paved ? Material::kAsphalt : Material::kSoil;
  };
  AddGround(road.ground, *road.index, {reach, 0.5, 14, 4}, material, &scene.mesh);
  for (const double side : {-1.0, 1.0}) {
    if (random.Chance(0.75)) AddRails(road, side, random, &scene.mesh);
    if (random.Chance(0.2)) {
      const double left = road.Left(side);
      AddBand(*road.path, {0, road.path->length(), left, -0.1, 0.12, Material::kStone}, road.ground,
              &scene.mesh);
    }
  }
  AddPoles(road, random, &scene.mesh);
  AddCountry(road, reach, need.season, random, &scene.mesh);
  scene.oncoming_left_m = -2 * road.lane_m;
  const int oncoming = random.Chance(0.4) ? 0 : random.Index(25);
  for (int i = 0; i < oncoming; ++i) {
    const double speed = random.Uniform(5, 20),
                 from = random.Uniform(0, 2 * need.path_length_m + 600);
    scene.cars.push_back(
        CarOn(road.path, -2 * road.lane_m, true, [=](double t) { return from - speed * t; }));
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
