// The motion model: a prediction of the sensor's motion before a scan is matched, and its
// uncertainty.
#pragma once

#include "core/pose.h"
#include "floam/match/limits.h"

namespace isthmus::floam {

// Constant velocity with white noise on the acceleration (Barfoot, "State Estimation for Robotics",
// section 11.1): over t seconds the position goes astray by q t^3 / 3, the velocity by q t, and
// both together by q t^2 / 2. Scans say where the sensor was, and with that how fast it came there,
// by as much as they observe; along what they do not the velocity grows uncertain. Not thread safe.
class MotionModel {
 public:
  // From now on the motion is taken to change as that of anything may, or, where the way along is
  // not observed, as much as this robot's was seen to change (density of the white noise, m^2/s^3;
  // never by more): what little is seen along it would draw the estimate about.
  void ExpectAnything();
  void ExpectAcceleration(double density);
  // The covariance, `elapsed_s` after the last scan, of the twist by which the sensor may be
  // elsewhere than if the motion went on; twist order [rho; phi], sensor frame, m^2 and rad^2.
  Matrix6d Displacement(double elapsed_s) const;
  // One sigma of how much, of anything, the twist changes in that time.
  static Vector6d TwistChange(double elapsed_s);
  // A scan was matched, after which that covariance is `posterior`.
  void Update(double elapsed_s, const Matrix6d& posterior);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.velocity_, self.acceleration_);
    if constexpr (Io::kIsReading)
      io.Expect(self.velocity_.allFinite() && self.acceleration_ >= 0 && self.acceleration_ < 1e3);
  }

 private:
  Matrix6d Density() const;

  Matrix6d velocity_ = Matrix6d::Zero();      // Covariance of the twist at the last scan.
  double acceleration_ = kAccelerationNoise;  // Density of its noise in use, m^2/s^3.
};

}  // namespace isthmus::floam
