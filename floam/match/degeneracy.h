// Degeneracy: the directions of motion that a set of matches does not observe.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace isthmus::floam {

// Directions are unit vectors in the frame of the information matrix.
struct Degeneracy {
  std::vector<Eigen::Vector3d> translations;
  std::vector<Eigen::Vector3d> rotations;

  bool any() const { return !translations.empty() || !rotations.empty(); }
};

Degeneracy Everything();
// The same directions in the frame R * that of `degeneracy`.
Degeneracy Rotated(const Eigen::Matrix3d& R, Degeneracy degeneracy);
// Adds so much variance, m^2 and rad^2, along each of its directions.
void Widen(const Degeneracy& degeneracy, double translation, double rotation, Matrix6d* covariance);

// `information` is what the matches say of a motion [rho; phi], 1/m^2 and 1/rad^2, with that from
// noise taken off (see MatchInformation); `prior` the covariance of what was known without them. A
// direction counts as not observed if the matches leave more than half of its variance: then what
// was assumed of the motion decides, not what was seen.
Degeneracy FindDegeneracy(const Matrix6d& information, const Matrix6d& prior);

}  // namespace isthmus::floam
