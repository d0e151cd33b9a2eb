// Ground that is not flat, and rock.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/mesh.h"
#include "lab/simulation/wild/path.h"

namespace isthmus::simulation::wild {

// Smooth noise in [-1, 1] of wavelength 1 or so: values at the corners of unit cubes, between them
// fifth-order polynomials (Perlin, "Improving noise", SIGGRAPH 2002, on values instead of
// gradients). Immutable.
class SmoothNoise {
 public:
  explicit SmoothNoise(uint64_t seed) : seed_(seed) {}
  double At(const Eigen::Vector3d& at) const;

 private:
  uint64_t seed_;
};

// Sum of noises, each of half the wavelength of the one before and `persistence` its amplitude.
class Rock {
 public:
  Rock(double wave_m, double amplitude_m, int octaves, double persistence, Random& random);
  double At(const Eigen::Vector3d& at) const;

 private:
  double wave_m_, amplitude_m_, persistence_;
  std::vector<SmoothNoise> octaves_;
};

struct Relief {
  double slope = 0;        // Rise over run; seldom more.
  double roughness_m = 0;  // About so uneven over wavelengths of 6 m and less.
};
HeightAt Hills(const Relief& relief, Random& random);

struct GroundCover {
  double reach_m = 60;  // Ground up to so far from the path.
  double fine_m = 0.5;  // Cells near the path ...
  double fine_reach_m = 20;
  double coarse_m = 2;                              // ... and elsewhere.
  Eigen::Vector2d low{-1e9, -1e9}, high{1e9, 1e9};  // None beyond.
  PointClass surface = PointClass::kGround;
};

// Adds the ground around a path; `material` of a place.
void AddGround(const HeightAt& height, const PathIndex& path, const GroundCover& cover,
               const std::function<Material(const Eigen::Vector2d&)>& material, Mesh* mesh);

}  // namespace isthmus::simulation::wild
