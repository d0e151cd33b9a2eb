#include "floam/match/motion_model.h"

#include <Eigen/LU>
#include <algorithm>

#include "floam/match/limits.h"

namespace isthmus::floam {
namespace {

Vector6d Densities(double acceleration) {
  Vector6d density;
  density << Eigen::Vector3d::Constant(acceleration), Eigen::Vector3d::Constant(kTurningNoise);
  return density;
}

}  // namespace

void MotionModel::ExpectAnything() { acceleration_ = kAccelerationNoise; }

void MotionModel::ExpectAcceleration(double density) {
  acceleration_ = std::clamp(density, kLeastAccelerationNoise, kAccelerationNoise);
}

Matrix6d MotionModel::Density() const { return Densities(acceleration_).asDiagonal(); }

Matrix6d MotionModel::Displacement(double elapsed_s) const {
  const double t2 = elapsed_s * elapsed_s;
  return t2 * velocity_ + t2 * elapsed_s / 3 * Density();
}

Vector6d MotionModel::TwistChange(double elapsed_s) {
  return (elapsed_s * Densities(kAccelerationNoise)).cwiseSqrt();
}

void MotionModel::Update(double elapsed_s, const Matrix6d& posterior) {
  const Matrix6d prior = Displacement(elapsed_s);
  const Matrix6d mixed = elapsed_s * velocity_ + 0.5 * elapsed_s * elapsed_s * Density();
  const Matrix6d gain = mixed * prior.inverse();
  velocity_ += elapsed_s * Density() - gain * (prior - posterior) * gain.transpose();
  velocity_ = (0.5 * (velocity_ + velocity_.transpose())).eval();
}

}  // namespace isthmus::floam
