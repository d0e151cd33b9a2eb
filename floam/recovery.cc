#include "floam/recovery.h"

#include <algorithm>
#include <numbers>

namespace isthmus::floam {
namespace {

constexpr double kMaxExtrapolationS = 3;
constexpr double kYawStepRad = 0.2;      // Less than what matching converges from.
constexpr double kYawRateRadPerS = 0.6;  // Errors of the heading grow by this.

}  // namespace

ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s) {
  const double time_s = std::min(elapsed_s, kMaxExtrapolationS) + reference_s;
  return {last.At(time_s), last.twist, reference_s};
}

std::vector<ScanPose> RecoveryGuesses(const ScanPose& last, double elapsed_s, double reference_s) {
  const double reach = std::min(std::numbers::pi, kYawStepRad + kYawRateRadPerS * elapsed_s);
  std::vector<ScanPose> guesses;
  for (int step = 0; step * kYawStepRad <= reach; ++step) {
    for (const double sign : {1.0, -1.0}) {
      if (step == 0 && sign < 0) continue;
      const Pose turn = Pose::FromXyzRpy(0, 0, 0, 0, 0, sign * step * kYawStepRad);
      for (const double fraction : {1.0, 0.5, 0.0}) {
        ScanPose slowed = last;
        slowed.twist *= fraction;
        ScanPose guess = Predict(slowed, elapsed_s, reference_s);
        guess.T_odom_sensor = guess.T_odom_sensor * turn;
        guesses.push_back(guess);
      }
    }
  }
  return guesses;
}

}  // namespace isthmus::floam
