// Which directions of motion a set of matches does not observe.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace isthmus::floam {

// Directions are unit vectors in the frame of the information matrix.
struct Degeneracy {
  std::vector<Eigen::Vector3d> translations;
  std::vector<Eigen::Vector3d> rotations;
  // Smallest information per match about a translation, 1/m^2; what the decision rests on.
  double weakest = 0;

  bool any() const { return !translations.empty() || !rotations.empty(); }
};

// `information` is that of a motion [rho; phi] from `used` matches at `lever_m` from the origin
// (root mean square). A direction counts as not observed if the information about it, once the
// other part (rotation or translation) is free to follow, is below `least_per_match` (1/m^2;
// rotations at the lever). Measured with 2 cm of noise: museums 145-294, campuses 62-206, bare
// tunnels 0.2-1.7. The covariance alone claims 2.5 cm along a tunnel: noise of normals passes for
// information.
Degeneracy FindDegeneracy(const Matrix6d& information, int used, double lever_m,
                          double least_per_match);

}  // namespace isthmus::floam
