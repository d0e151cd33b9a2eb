// The evidence of a look at a voxel, as OctoMap has it.
#pragma once

#include <cmath>

namespace isthmus::composition {

// Probabilities; OctoMap's own where nothing else is said (Hornung et al., "OctoMap", 2013, eq. 2
// to 4).
struct SensorModel {
  double hit = 0.7;   // A voxel in which a ray ends is occupied; above 0.5.
  double miss = 0.4;  // A voxel that a ray went through is occupied; below 0.5.
  // All evidence is clamped to these: the wider apart they are, the longer it takes until a change
  // is believed.
  double least = 0.1192;
  double most = 0.971;
};

// ln(p / (1 - p)), rounded as OctoMap does.
inline float LogOdds(double probability) {
  return static_cast<float>(std::log(probability / (1 - probability)));
}

inline constexpr float kOccupiedLogOdds = 0;  // Math: what is there from here on, p = 0.5.

}  // namespace isthmus::composition
