#include "server/classes/upright.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "server/classes/limits.h"

namespace isthmus::classes {

Eigen::Vector3f EstimateUp(Moments* moments, const Eigen::Vector3f& guess) {
  Eigen::Vector3d up = guess.cast<double>();
  for (int round = 0; round < kUpRounds; ++round) {
    // Up has the smallest sum of squares with upright normals less level ones.
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    double points = 0;
    moments->ForEach(kUpLevel, [&](const Shape& shape, double n) {
      if (shape.planar < kEvenShape) return;
      const Eigen::Vector3d normal = shape.normal.cast<double>();
      const double cosine = std::abs(normal.dot(up));
      if (cosine > kUprightCosine && cosine < kLevelCosine) return;
      sum += (cosine < kUprightCosine ? n : -n) * normal * normal.transpose();
      points += n;
    });
    if (points < kFewestUpPoints) return guess;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
    const Eigen::Vector3d axis = solver.eigenvectors().col(0);
    up = axis.dot(up) < 0 ? Eigen::Vector3d(-axis) : axis;
  }
  return up.cast<float>();
}

}  // namespace isthmus::classes
