// Statistics of the points that fell into a voxel of the local map.
#pragma once

#include <Eigen/Core>

namespace isthmus::floam {

// Sums from which mean and covariance follow. Points are given relative to a centre near them, so
// that single precision is enough. Sums of voxels with the same centre add up.
struct VoxelSums {
  float count = 0;
  Eigen::Vector3f first = Eigen::Vector3f::Zero();
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  float ring = 0;  // The ring of all points, or kSeveral.

  static constexpr float kSeveral = -1;

  void Add(const Eigen::Vector3f& p, float of_ring) {
    ring = count == 0 || ring == of_ring ? of_ring : kSeveral;
    count += 1;
    first += p;
    xx += p.x() * p.x();
    xy += p.x() * p.y();
    xz += p.x() * p.z();
    yy += p.y() * p.y();
    yz += p.y() * p.z();
    zz += p.z() * p.z();
  }
  void Add(const VoxelSums& other);
  // Forgets a part of the past: as if only `factor` of every point had been seen.
  void Scale(float factor);
};

enum class ShapeKind { kPlane, kLine, kPole };

// A plane or line through the points of a voxel.
struct Shape {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();       // As the points were given.
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  // Normal of the plane; along the line.
  float variance = 0;  // Variance of the points off the plane, or off the line per axis; m^2.
  // The variance of the direction's own error per axis, from the noise of the points it was fitted
  // to; rad^2.
  float tilt_variance = 0;
  bool valid = false;
};

// Not valid if there are too few points or they do not have that shape. A plane must be wide in
// both of its directions, and both planes and lines crossed by more than one ring: a single one,
// with its range noise, or bending, or as the sensor pitches, otherwise passes for a plane that it
// is not, and pins the estimate to where the sensor was, which would have seen others had it moved.
Shape FitShape(const VoxelSums& sums, ShapeKind kind);

}  // namespace isthmus::floam
