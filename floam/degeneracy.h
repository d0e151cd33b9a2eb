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
  // Smallest information per match about a translation, and about a rotation at the lever: shares
  // of what a match along that direction would give. What the decision rests on.
  double weakest_translation = 0;
  double weakest_rotation = 0;

  bool any() const { return !translations.empty() || !rotations.empty(); }
};

// `information` is that of a motion [rho; phi] from `used` matches at `lever_m` from the origin
// (root mean square), in units of what one match tells about its distance. A direction counts as
// not observed if the information about it per match, once the other part (rotation or translation)
// is free to follow, is below `least_share`; a 30th of that for rotations, which floor and ceiling
// observe at a short lever. Seen: museums 0.05-0.15, campuses 0.04-0.15, bare tunnels 1e-4-1e-3;
// from 0.015 down, steps along a corridor are off by more than 2 cm.
// The covariance alone claims 2.5 cm along a tunnel: noise of normals passes for information.
Degeneracy FindDegeneracy(const Matrix6d& information, int used, double lever_m,
                          double least_share);

}  // namespace isthmus::floam
