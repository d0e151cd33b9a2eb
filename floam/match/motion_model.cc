#include "floam/match/motion_model.h"

#include <Eigen/LU>
#include <algorithm>

namespace isthmus::floam {
namespace {

// Density of the white noise on turning, rad^2/s^3: 0.45 rad/s in a second.
constexpr double kTurningDensity = 0.2;
constexpr double kLeastAcceleration = 0.005;  // 0.07 m/s in a second.

Vector6d Densities(double acceleration) {
  Vector6d density;
  density << Eigen::Vector3d::Constant(acceleration), Eigen::Vector3d::Constant(kTurningDensity);
  return density;
}

}  // namespace

void MotionModel::ExpectAnything() { acceleration_ = kAcceleration; }

void MotionModel::ExpectAcceleration(double density) {
  acceleration_ = std::clamp(density, kLeastAcceleration, kAcceleration);
}

Matrix6d MotionModel::Density() const { return Densities(acceleration_).asDiagonal(); }

Matrix6d MotionModel::Displacement(double elapsed_s) const {
  const double t2 = elapsed_s * elapsed_s;
  return t2 * velocity_ + t2 * elapsed_s / 3 * Density();
}

Vector6d MotionModel::TwistChange(double elapsed_s) {
  return (elapsed_s * Densities(kAcceleration)).cwiseSqrt();
}

void MotionModel::Update(double elapsed_s, const Matrix6d& posterior) {
  const Matrix6d prior = Displacement(elapsed_s);
  const Matrix6d mixed = elapsed_s * velocity_ + 0.5 * elapsed_s * elapsed_s * Density();
  const Matrix6d gain = mixed * prior.inverse();
  velocity_ += elapsed_s * Density() - gain * (prior - posterior) * gain.transpose();
  velocity_ = (0.5 * (velocity_ + velocity_.transpose())).eval();
}

}  // namespace isthmus::floam
