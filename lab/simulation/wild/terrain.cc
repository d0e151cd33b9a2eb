#include "lab/simulation/wild/terrain.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace isthmus::simulation::wild {
namespace {

double Ease(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

// A square of ground as a grid of its own.
void AddPatch(const HeightAt& height, const Eigen::Vector2d& corner, double side_m, double cell_m,
              const std::function<Material(const Eigen::Vector2d&)>& material, Mesh* mesh) {
  const auto count = static_cast<uint32_t>(std::lround(side_m / cell_m));
  const auto first = static_cast<uint32_t>(mesh->vertices.size());
  for (uint32_t i = 0; i <= count; ++i) {
    for (uint32_t k = 0; k <= count; ++k) {
      const Eigen::Vector2d at = corner + cell_m * Eigen::Vector2d(k, i);
      mesh->vertices.push_back(Eigen::Vector3d(at.x(), at.y(), height(at)).cast<float>());
    }
  }
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t a = first + i * (count + 1) + k, b = a + count + 1;
      mesh->triangles.push_back({a, a + 1, b + 1});
      mesh->triangles.push_back({a, b + 1, b});
      const Material is = material(corner + cell_m * Eigen::Vector2d(k + 0.5, i + 0.5));
      mesh->materials.insert(mesh->materials.end(), 2, is);
      mesh->classes.insert(mesh->classes.end(), 2, mesh->adds);
    }
  }
}

}  // namespace

double SmoothNoise::At(const Eigen::Vector3d& at) const {
  const Eigen::Vector3d floor = at.array().floor();
  const Eigen::Vector3d t = at - floor;
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    uint64_t z = seed_;
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int upper = corner >> axis & 1;
      weight *= upper ? Ease(t[axis]) : 1 - Ease(t[axis]);
      z += static_cast<uint64_t>(static_cast<int64_t>(floor[axis]) + upper);
      z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u + 0x9E3779B97F4A7C15u;
    }
    if (weight == 0) continue;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    value += weight * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-52 - 1);
  }
  return value;
}

Rock::Rock(double wave_m, double amplitude_m, int octaves, double persistence, Random& random)
    : wave_m_(wave_m), amplitude_m_(amplitude_m), persistence_(persistence) {
  for (int i = 0; i < octaves; ++i) octaves_.emplace_back(random.Next());
}

double Rock::At(const Eigen::Vector3d& at) const {
  double value = 0, amplitude = amplitude_m_, scale = 1 / wave_m_;
  for (const SmoothNoise& octave : octaves_) {
    value += amplitude * octave.At(scale * at);
    amplitude *= persistence_;
    scale *= 2;
  }
  return value;
}

HeightAt Hills(const Relief& relief, Random& random) {
  const double wave = random.Uniform(30, 120);
  // Between two values 1 apart the noise rises by 1.9 a wavelength at most, and twice that is rare.
  const auto hills = std::make_shared<Rock>(wave, relief.slope * wave / 2.2, 2, 0.3, random);
  const auto rough = std::make_shared<Rock>(6, relief.roughness_m, 3, 0.45, random);
  return [hills, rough](const Eigen::Vector2d& at) {
    const Eigen::Vector3d level(at.x(), at.y(), 0.5);
    return hills->At(level) + rough->At(level);
  };
}

void AddGround(const HeightAt& height, const PathIndex& path, const GroundCover& cover,
               const std::function<Material(const Eigen::Vector2d&)>& material, Mesh* mesh) {
  constexpr double kPatch = 8;
  const As as(mesh, cover.surface);
  const double reach = cover.reach_m;
  for (double x = path.min().x() - reach; x < path.max().x() + reach; x += kPatch) {
    for (double y = path.min().y() - reach; y < path.max().y() + reach; y += kPatch) {
      const Eigen::Vector2d corner(x, y);
      if (x > cover.high.x() || y > cover.high.y()) continue;
      if (x + kPatch < cover.low.x() || y + kPatch < cover.low.y()) continue;
      const double distance = path.Distance(corner.array() + kPatch / 2, reach);
      if (distance >= reach) continue;
      const double cell = distance < cover.fine_reach_m ? cover.fine_m : cover.coarse_m;
      AddPatch(height, corner, kPatch, cell, material, mesh);
    }
  }
}

}  // namespace isthmus::simulation::wild
