#include "floam/unobserved_motion.h"

#include <algorithm>

#include "floam/pose_covariance.h"

namespace isthmus::floam {
namespace {

// Densities of the white noise, m^2/s^3 and rad^2/s^3. After kKnownS the speed is as uncertain as
// it can be, 1 m/s, and the rate of turning, 0.3 rad/s: robots brake, stop and turn in a second.
constexpr double kAcceleration = 1, kTurning = 0.1;
constexpr double kKnownS = 1;
constexpr double kLastingS = 0.55;

// Integral of density t^2 over the next `elapsed_s` after `blind_s`, with t at most kKnownS.
double Growth(double density, double blind_s, double elapsed_s) {
  const double from = std::min(blind_s, kKnownS);
  const double to = std::min(blind_s + elapsed_s, kKnownS);
  const double evenly_s = elapsed_s - (to - from);
  return density * ((to * to * to - from * from * from) / 3 + kKnownS * kKnownS * evenly_s);
}

Degeneracy Rotated(const Eigen::Matrix3d& R, Degeneracy degeneracy) {
  for (Eigen::Vector3d& d : degeneracy.translations) d = R * d;
  for (Eigen::Vector3d& d : degeneracy.rotations) d = R * d;
  return degeneracy;
}

}  // namespace

Degeneracy UnobservedMotion::Lasting(const Degeneracy& degeneracy,
                                     const Eigen::Matrix3d& R_odom_sensor, double elapsed_s) {
  if (degeneracy.any()) {
    lasting_odom_ = Rotated(R_odom_sensor, degeneracy);
    lasted_s_ = 0;
    return degeneracy;
  }
  lasted_s_ += elapsed_s;
  if (lasted_s_ > kLastingS) lasting_odom_ = Degeneracy();
  return Rotated(R_odom_sensor.transpose(), lasting_odom_);
}

Matrix6d UnobservedMotion::Step(const Degeneracy& unobserved, double elapsed_s) {
  Matrix6d covariance = Matrix6d::Zero();
  const double translation = Growth(kAcceleration, blind_translation_s_, elapsed_s);
  for (const Eigen::Vector3d& d : unobserved.translations) {
    covariance.topLeftCorner<3, 3>() += translation * d * d.transpose();
  }
  const double rotation = Growth(kTurning, blind_rotation_s_, elapsed_s);
  for (const Eigen::Vector3d& d : unobserved.rotations) {
    covariance.bottomRightCorner<3, 3>() += rotation * d * d.transpose();
  }
  blind_translation_s_ = unobserved.translations.empty() ? 0 : blind_translation_s_ + elapsed_s;
  blind_rotation_s_ = unobserved.rotations.empty() ? 0 : blind_rotation_s_ + elapsed_s;
  return covariance;
}

Matrix6d UnobservedMotion::LostStep(double elapsed_s) {
  Degeneracy all;
  for (int axis = 0; axis < 3; ++axis) {
    all.translations.push_back(Eigen::Vector3d::Unit(axis));
    all.rotations.push_back(Eigen::Vector3d::Unit(axis));
  }
  return Step(all, elapsed_s);
}

Matrix6d UnobservedMotion::CarriedStep() {
  blind_translation_s_ = blind_rotation_s_ = 0;
  return LostCovariance();
}

}  // namespace isthmus::floam
