#include "floam/motion_model.h"

#include <Eigen/LU>

namespace isthmus::floam {
namespace {

// Densities of the white noise, m^2/s^3 and rad^2/s^3: 0.7 m/s and 0.45 rad/s in a second. Cars
// brake harder, which scans show; where they do not, a motion that mostly goes on is the better
// guess. Calibrated on a recorded street, a bare corridor and two tunnels.
constexpr double kAcceleration = 0.5, kTurning = 0.2;

Matrix6d Density() {
  Vector6d density;
  density << Eigen::Vector3d::Constant(kAcceleration), Eigen::Vector3d::Constant(kTurning);
  return density.asDiagonal();
}

}  // namespace

Matrix6d MotionModel::Displacement(double elapsed_s) const {
  const double t2 = elapsed_s * elapsed_s;
  return t2 * velocity_ + t2 * elapsed_s / 3 * Density();
}

Vector6d MotionModel::TwistChange(double elapsed_s) {
  return (elapsed_s * Density().diagonal()).cwiseSqrt();
}

void MotionModel::Update(double elapsed_s, const Matrix6d& posterior) {
  const Matrix6d prior = Displacement(elapsed_s);
  const Matrix6d mixed = elapsed_s * velocity_ + 0.5 * elapsed_s * elapsed_s * Density();
  const Matrix6d gain = mixed * prior.inverse();
  velocity_ += elapsed_s * Density() - gain * (prior - posterior) * gain.transpose();
  velocity_ = (0.5 * (velocity_ + velocity_.transpose())).eval();
}

}  // namespace isthmus::floam
