// Coordinates of a map projection (UTM, say), brought near the origin: one rule for all that reads
// poses or clouds.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace isthmus {

// The shift to be added to coordinates around `place`, m: whole kilometres, of every axis; zero
// where it is within 2 km of the origin along each, and where it is not finite or nowhere on Earth.
Eigen::Vector3d ShiftToOrigin(const Eigen::Vector3d& place);

// The median of each coordinate, of those that are finite; zero without any.
Eigen::Vector3d MiddleOf(const std::vector<double>& x, const std::vector<double>& y,
                         const std::vector<double>& z);

// "A.las is far from its origin: -500000 -5334000 0 m are added to its coordinates".
std::string ShiftText(const std::string& file, const Eigen::Vector3d& shift);

}  // namespace isthmus
