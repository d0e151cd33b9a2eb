// The uncertainty of motion that no scan observed and that was assumed instead.
#pragma once

#include "core/pose.h"
#include "floam/match/degeneracy.h"

namespace isthmus::floam {

// Along what a scan does not observe, the motion is assumed to go on as before. The error grows
// with the time that nothing is seen: acceleration is taken as white noise, which makes the
// variance of the position grow with the third power, q t^3 / 3 (Barfoot, "State Estimation for
// Robotics", section 11.1), until the speed is as uncertain as it can be; from then on evenly. A
// scan that observes all again says how fast it goes, not how far it came: what was lost stays
// lost.
//
// The results are covariances of steps, from one scan to the next, in the sensor frame at the END
// of the later one, twist order [rho; phi]; those of steps under way add up. Not thread safe.
class UnobservedMotion {
 public:
  // Directions that count as not observed in a scan `elapsed_s` after the one before: those that it
  // does not observe or, where it observes all, what one did not up to half a second ago. The first
  // that sees something again tells where the sensor is in a map that came along with it.
  Degeneracy Lasting(const Degeneracy& degeneracy, const Eigen::Matrix3d& R_odom_sensor,
                     double elapsed_s);
  // The uncertainty of a step of `elapsed_s` to a scan that was matched, with its unobserved
  // directions at the END.
  Matrix6d Step(const Degeneracy& unobserved, double elapsed_s);
  // To one that could not be matched.
  Matrix6d LostStep(double elapsed_s);
  // To one that was found far from where it should be: seen in the map, but a place that looks the
  // same would have been taken for it.
  Matrix6d StepAfterRelocalisation();

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.blind_translation_s_, self.blind_rotation_s_, self.lasting_odom_.translations,
       self.lasting_odom_.rotations, self.lasted_s_);
    if constexpr (Io::kIsReading) {
      io.Expect(self.lasting_odom_.translations.size() <= 3 &&
                self.lasting_odom_.rotations.size() <= 3);
    }
  }

 private:
  // Since when some translation, or rotation, was not observed.
  double blind_translation_s_ = 0, blind_rotation_s_ = 0;
  Degeneracy lasting_odom_;  // Directions not observed last, ...
  double lasted_s_ = 0;      // ... and how long ago.
};

}  // namespace isthmus::floam
