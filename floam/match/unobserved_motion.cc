#include "floam/match/unobserved_motion.h"

#include <algorithm>

#include "floam/match/limits.h"
#include "floam/match/pose_covariance.h"

namespace isthmus::floam {
namespace {

// Integral of density t^2 over the next `elapsed_s` after `blind_s`, with t at most kSpeedKnownS.
double Growth(double density, double blind_s, double elapsed_s) {
  const double from = std::min(blind_s, kSpeedKnownS);
  const double to = std::min(blind_s + elapsed_s, kSpeedKnownS);
  const double evenly_s = elapsed_s - (to - from);
  return density *
         ((to * to * to - from * from * from) / 3 + kSpeedKnownS * kSpeedKnownS * evenly_s);
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
  if (lasted_s_ > kUnobservedLastsS) lasting_odom_ = Degeneracy();
  return Rotated(R_odom_sensor.transpose(), lasting_odom_);
}

Matrix6d UnobservedMotion::Step(const Degeneracy& unobserved, double elapsed_s) {
  Matrix6d covariance = Matrix6d::Zero();
  Widen(unobserved, Growth(kUnobservedAcceleration, blind_translation_s_, elapsed_s),
        Growth(kUnobservedTurning, blind_rotation_s_, elapsed_s), &covariance);
  blind_translation_s_ = unobserved.translations.empty() ? 0 : blind_translation_s_ + elapsed_s;
  blind_rotation_s_ = unobserved.rotations.empty() ? 0 : blind_rotation_s_ + elapsed_s;
  return covariance;
}

Matrix6d UnobservedMotion::LostStep(double elapsed_s) { return Step(Everything(), elapsed_s); }

Matrix6d UnobservedMotion::StepAfterRelocalisation() {
  blind_translation_s_ = blind_rotation_s_ = 0;
  return LostCovariance();
}

}  // namespace isthmus::floam
