#include "floam/map/voxel_statistics.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "floam/map/limits.h"

namespace isthmus::floam {
void VoxelSums::Add(const VoxelSums& other) {
  if (other.count == 0) return;
  ring = count == 0 || ring == other.ring ? other.ring : kSeveral;
  count += other.count;
  first += other.first;
  xx += other.xx;
  xy += other.xy;
  xz += other.xz;
  yy += other.yy;
  yz += other.yz;
  zz += other.zz;
}

void VoxelSums::Scale(float factor) {
  count *= factor;
  first *= factor;
  xx *= factor;
  xy *= factor;
  xz *= factor;
  yy *= factor;
  yz *= factor;
  zz *= factor;
}

Shape FitShape(const VoxelSums& sums, ShapeKind kind) {
  Shape shape;
  if (sums.count < (kind == ShapeKind::kPole ? kMinPolePoints : kMinShapePoints)) return shape;
  const float inverse = 1 / sums.count;
  shape.mean = inverse * sums.first;
  Eigen::Matrix3f covariance;
  covariance << sums.xx, sums.xy, sums.xz, sums.xy, sums.yy, sums.yz, sums.xz, sums.yz, sums.zz;
  covariance = inverse * covariance - shape.mean * shape.mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3f& eigenvalues = solver.eigenvalues();  // Ascending.
  if (kind == ShapeKind::kPole) {
    shape.variance = std::max(0.5F * (eigenvalues[0] + eigenvalues[1]), 0.F);
    shape.valid = shape.variance < kMaxPoleVariance;
    return shape;
  }
  const int axis = kind == ShapeKind::kPlane ? 0 : 2;
  shape.direction = solver.eigenvectors().col(axis);
  if (kind == ShapeKind::kPlane) {
    shape.valid =
        eigenvalues[1] > kMinShapeVariance && eigenvalues[0] < kMaxFlatness * eigenvalues[1];
    shape.variance = std::max(eigenvalues[0], 0.F);
  } else {
    shape.valid =
        eigenvalues[2] > kMinShapeVariance && eigenvalues[1] < kMaxSlimness * eigenvalues[2];
    shape.variance = std::max(0.5F * (eigenvalues[0] + eigenvalues[1]), 0.F);
  }
  // To first order in the noise, lambda_0 lambda_1 / (N (lambda_1 - lambda_0)^2) along the axis of
  // lambda_1: of both axes the one that is known less.
  const float gap =
      kind == ShapeKind::kPlane ? eigenvalues[1] - eigenvalues[0] : eigenvalues[2] - eigenvalues[1];
  const float spread = kind == ShapeKind::kPlane ? eigenvalues[1] : eigenvalues[2];
  shape.tilt_variance = shape.variance * spread * inverse / std::max(gap * gap, 1e-12F);
  if (sums.ring != VoxelSums::kSeveral) shape.valid = false;
  shape.valid = shape.valid && shape.direction.allFinite();
  return shape;
}

}  // namespace isthmus::floam
