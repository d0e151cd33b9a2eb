#include "floam/match/unobserved_motion.h"

#include <algorithm>

#include "floam/match/pose_covariance.h"

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
  Widen(unobserved, Growth(kAcceleration, blind_translation_s_, elapsed_s),
        Growth(kTurning, blind_rotation_s_, elapsed_s), &covariance);
  blind_translation_s_ = unobserved.translations.empty() ? 0 : blind_translation_s_ + elapsed_s;
  blind_rotation_s_ = unobserved.rotations.empty() ? 0 : blind_rotation_s_ + elapsed_s;
  return covariance;
}

Matrix6d UnobservedMotion::LostStep(double elapsed_s) { return Step(Everything(), elapsed_s); }

Matrix6d UnobservedMotion::CarriedStep() {
  blind_translation_s_ = blind_rotation_s_ = 0;
  return LostCovariance();
}

}  // namespace isthmus::floam
