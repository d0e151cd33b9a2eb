// A tunnel with bends and alcoves, smooth or of rough rock, bare or with cables, ribs and lamps.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

struct Alcove {
  double s, half_m, deep_m;
  int side;  // 1: left.
};

struct Bore {
  double half_m, height_m;  // Clear width by two, clear height.
  double roundness;         // 0: a rectangle, 1: an ellipse.
  double left_m = 0;        // Its middle, from the path.
  std::vector<Alcove> alcoves;
  double drift_m = 0;  // Amplitude of the changes of its width.
};

Bore DrawBore(const Need& need, double length_m, Random& random) {
  Bore bore;
  const bool car = need.carrier.gait == Gait::kCar;
  const double least = need.clear_m() + 0.3;
  bore.half_m = least + random.Uniform(0.2, car ? 4 : 2.5);
  bore.height_m = std::max(need.clear_height_m() + 0.4, random.Uniform(2.2, car ? 8 : 5));
  bore.roundness = random.Unit();
  bore.left_m = random.Uniform(-1, 1) * std::max(0.0, bore.half_m - least - 0.3);
  bore.drift_m = random.Chance(0.5) ? 0 : random.Uniform(0, 0.2 * bore.half_m);
  const double every = random.Chance(0.2) ? 1e9 : random.Uniform(15, 120);
  for (double s = random.Uniform(0, every); s < length_m; s += every * random.Uniform(0.3, 1.7)) {
    bore.alcoves.push_back(
        {s, random.Uniform(1, 5), random.Uniform(0.5, 5), random.Chance(0.5) ? 1 : -1});
  }
  return bore;
}

// The outline at `angle` (0: to the left, a quarter turn: up): left and up from the middle of the
// floor.
Eigen::Vector2d Outline(const Bore& bore, double s, double angle, double wider_m) {
  // A superellipse: exponent 2 is an ellipse, 8 nearly a rectangle.
  const double exponent = 2 + 6 * (1 - bore.roundness);
  const double c = std::cos(angle), n = std::sin(angle);
  const double r =
      std::pow(std::pow(std::abs(c), exponent) + std::pow(std::abs(n), exponent), -1 / exponent);
  double left = r * c * (bore.half_m + wider_m);
  const double up = bore.height_m * std::max(0.0, 0.3 + 0.7 * r * n);
  for (const Alcove& alcove : bore.alcoves) {
    const bool within = std::abs(s - alcove.s) < alcove.half_m && up < 0.8 * bore.height_m;
    if (within && c * alcove.side > 0.5) left += alcove.side * alcove.deep_m;
  }
  return {left + bore.left_m, up};
}

// By the slope of a piece of the lining, and the half of the bore that it is in.
PointClass ClassOf(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                   double middle_z) {
  constexpr float kLevel = 0.7f;  // Up to 45 degrees.
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  if (std::abs(normal.z()) < kLevel * normal.norm()) return PointClass::kWall;
  return (a.z() + b.z() + c.z()) / 3 < middle_z ? PointClass::kGround : PointClass::kCeiling;
}

void AddBore(const Path& path, const Bore& bore, const Rock& rock, const Rock& wider, double step_m,
             Material material, Mesh* mesh) {
  constexpr int kSides = 40;
  uint32_t before = 0;
  const auto rings = static_cast<int>(path.length() / step_m);
  for (int ring = 0; ring <= rings; ++ring) {
    const double s = ring * step_m;
    const Path::Sample on = path.At(s);
    const Eigen::Vector3d left(-std::sin(on.yaw), std::cos(on.yaw), 0);
    const auto first = static_cast<uint32_t>(mesh->vertices.size());
    for (int side = 0; side < kSides; ++side) {
      const double angle = 2 * std::numbers::pi * side / kSides;
      const Eigen::Vector2d at = Outline(bore, s, angle, std::max(0.0, wider.At({s, 0, 0})));
      Eigen::Vector3d p = on.position + at.x() * left + Eigen::Vector3d(0, 0, at.y());
      // Rock stands back from the outline, never in the way.
      const double back = std::abs(rock.At(p));
      p += back * (std::cos(angle) * left + Eigen::Vector3d(0, 0, std::sin(angle) > 0 ? 1 : -0.1));
      mesh->vertices.push_back(p.cast<float>());
    }
    for (uint32_t side = 0; ring > 0 && side < kSides; ++side) {
      const uint32_t next = (side + 1) % kSides;
      mesh->triangles.push_back({before + side, before + next, first + next});
      mesh->triangles.push_back({before + side, first + next, first + side});
      mesh->materials.insert(mesh->materials.end(), 2, material);
      for (const auto& [a, b, c] : {mesh->triangles.end()[-2], mesh->triangles.end()[-1]}) {
        const auto& at = mesh->vertices;
        mesh->classes.push_back(ClassOf(at[a], at[b], at[c], on.position.z() + bore.height_m / 2));
      }
    }
    before = first;
  }
}

// Cables along a wall, ribs across, lamps.
void AddFittings(const Path& path, const Bore& bore, Random& random, Mesh* mesh) {
  const As fitting(mesh, PointClass::kStructure);
  for (int i = random.Index(5); i > 0; --i) {
    const double angle = random.Chance(0.5) ? random.Uniform(0.2, 0.8) : random.Uniform(2.3, 2.9);
    const double radius = random.Uniform(0.02, 0.15);
    const Eigen::Vector2d at = Outline(bore, -1e9, angle, 0);
    const double left = at.x() - std::copysign(radius + 0.05, std::cos(angle));
    if (std::abs(left) < 0.8 * std::abs(at.x())) continue;
    for (double s = 0; s + 2 < path.length(); s += 2) {
      const Eigen::Vector3d up(0, 0, at.y() - radius);
      AddTube(path.Beside(s, left) + up, path.Beside(s + 2, left) + up, radius, radius, 6,
              Material::kMetal, mesh);
    }
  }
  const double ribs = random.Chance(0.5) ? 0 : random.Uniform(1, 12);
  const double deep = random.Uniform(0.05, 0.2);
  for (double s = 2; ribs > 0 && s < path.length(); s += ribs) {
    for (const double angle : {0.5, 1.0, 1.5, 2.0}) {
      const Eigen::Vector2d a = Outline(bore, -1e9, angle, 0),
                            b = Outline(bore, -1e9, angle + 0.5, 0);
      AddTube(path.Beside(s, a.x()) + Eigen::Vector3d(0, 0, a.y()),
              path.Beside(s, b.x()) + Eigen::Vector3d(0, 0, b.y()), deep, deep, 5, Material::kMetal,
              mesh);
    }
  }
}

}  // namespace

Scene MakeTunnel(const Need& need, Random& random) {
  Scene scene;
  const double radius = std::max(6.0, need.carrier.speed_mps * random.Uniform(2, 12));
  scene.path = std::make_shared<Path>(Path::Wandering(
      {need.path_length_m + 90, random.Uniform(25, 200), random.Uniform(0, 1.2), radius}, random));
  scene.begin_m = 30;
  const HeightAt slope = Hills({random.Uniform(0, 0.15), 0}, random);
  scene.path->Lay(slope, 6);  // Smooth, and level across.
  const double length = scene.path->length();
  const Bore bore = DrawBore(need, length, random);
  const double rough = random.Chance(0.35) ? random.Uniform(0, 0.02) : random.Uniform(0.02, 0.5);
  const Rock rock(random.Uniform(0.8, 4), rough, 3, 0.5, random);
  const Rock wider(25, bore.drift_m, 2, 0.5, random);
  const double step = std::max(0.3, length / 4000);
  AddBore(*scene.path, bore, rock, wider, step,
          rough > 0.05 ? Material::kStone : Material::kPlaster, &scene.mesh);
  AddFittings(*scene.path, bore, random, &scene.mesh);
  return scene;
}

}  // namespace isthmus::simulation::wild
