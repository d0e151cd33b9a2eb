#include "lab/simulation/manoeuvre.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/angles.h"

namespace isthmus::simulation {
namespace {

const Pose kPlace = Pose::FromXyzRpy(3, -2, 0.8, 0.02, -0.03, 2.5);

TEST(StandStill, StaysWhereItIs) {
  const Motion motion = StandStill(kPlace);
  for (const double t : {-1.0, 0.0, 600.0}) EXPECT_EQ(motion(t).Matrix(), kPlace.Matrix());
}

TEST(SpinInPlace, StandsThenTurnsAboutItsOwnAxis) {
  const Motion motion = SpinInPlace(kPlace, 60 * kRadPerDeg, 2, 1);
  EXPECT_EQ(motion(2).Matrix(), kPlace.Matrix());
  for (double t = 0; t < 40; t += 0.37) {
    EXPECT_LT((motion(t).translation() - kPlace.translation()).norm(), 1e-12);
    const Vector6d twist = Log(motion(t).Inverse() * motion(t + 1e-3)) / 1e-3;
    const double rate = std::clamp(t + 5e-4 - 2, 0.0, 1.0) * 60 * kRadPerDeg;
    EXPECT_NEAR(twist[5], rate, 2e-3) << t;
    EXPECT_LT(twist.head<5>().norm(), 1e-9) << t;
  }
  // Half a second's worth is lost to the ramp; six seconds are a turn.
  EXPECT_LT(RotationAngle(kPlace.Inverse() * motion(2.5 + 5 * 6)), 1e-9);
}

TEST(SpinInPlace, TurnsToTheRightToo) {
  const Motion motion = SpinInPlace(Pose(), -0.5, 0, 1);
  EXPECT_NEAR(motion(3).Yaw(), -0.5 * 2.5, 1e-9);
}

}  // namespace
}  // namespace isthmus::simulation
