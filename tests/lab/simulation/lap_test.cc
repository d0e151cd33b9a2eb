#include <gtest/gtest.h>

#include <cmath>

#include "lab/simulation/route.h"

namespace isthmus::simulation {
namespace {

constexpr double kTurn = 0.1;

Vector6d Velocity(const Motion& motion, double t) {
  return Log(motion(t - 1e-3).Inverse() * motion(t + 1e-3)) / 2e-3;
}

class EveryLap : public ::testing::TestWithParam<std::string> {
 protected:
  const World world_ = *MakeWorld(GetParam(), 1);
  const Lap lap_ = *MakeLap(world_, 60, kTurn, 1);
};

TEST_P(EveryLap, RepeatsItself) {
  for (double t = 0.03; t < lap_.seconds; t += 0.71) {
    const Pose once = lap_.motion(lap_.begin_s + t);
    const Pose much_later = lap_.motion(lap_.begin_s + t + 100 * lap_.seconds);
    EXPECT_LT((once.translation() - much_later.translation()).norm(), 1e-9);
    EXPECT_LT(RotationAngle(once.Inverse() * much_later), 1e-9);
  }
}

TEST_P(EveryLap, TakesWholeTurns) {
  EXPECT_NEAR(std::remainder(lap_.begin_s, kTurn), 0, 1e-9);
  EXPECT_NEAR(std::remainder(lap_.seconds, kTurn), 0, 1e-9);
}

TEST_P(EveryLap, CrossesItsStartWithoutAJump) {
  const double end = lap_.begin_s + lap_.seconds;
  const Pose before = lap_.motion(end - 1e-7), after = lap_.motion(end + 1e-7);
  EXPECT_LT((before.translation() - after.translation()).norm(), 1e-5);
  EXPECT_LT(RotationAngle(before.Inverse() * after), 1e-5);
  const Vector6d change = Velocity(lap_.motion, end + 0.01) - Velocity(lap_.motion, end - 0.01);
  EXPECT_LT(change.head<3>().norm(), 0.05 * world_.max_speed_mps);
  EXPECT_LT(change.tail<3>().norm(), 0.05);
}

TEST_P(EveryLap, StartsAtRestAndIsUnderWayWhenTheFirstLapBegins) {
  EXPECT_LT(Velocity(lap_.motion, 0.01).norm(), 1e-9);
  EXPECT_GT(Velocity(lap_.motion, lap_.begin_s).norm(), 0.2 * world_.max_speed_mps);
  const Vector6d change =
      Velocity(lap_.motion, lap_.begin_s + 0.01) - Velocity(lap_.motion, lap_.begin_s - 0.01);
  EXPECT_LT(change.norm(), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Worlds, EveryLap, ::testing::Values("museum", "campus"));

TEST(MakeLap, GoesAroundTheTourThatTheRobotHasAmongOthers) {
  const World world = *MakeWorld("campus", 1);
  const auto tours = *MakeRoutes(world, 2, 60, 1);
  for (int robot = 0; robot < 2; ++robot) {
    const auto lap = MakeLap(world, 60, kTurn, 1, {.robots = 2, .robot = robot});
    ASSERT_TRUE(lap.ok()) << lap.status();
    for (int other = 0; other < 2; ++other) {
      const double apart =
          (lap->motion(0).translation() - tours[other](0).translation()).head<2>().norm();
      EXPECT_EQ(apart < 1, robot == other) << apart;
    }
  }
}

TEST(MakeLap, RefusesARobotThatIsNotThere) {
  const World world = *MakeWorld("museum", 1);
  for (const int robot : {-1, 2}) {
    EXPECT_EQ(MakeLap(world, 60, kTurn, 1, {.robots = 2, .robot = robot}).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(MakeLap, RefusesTimesThatAreNotPositive) {
  const World world = *MakeWorld("museum", 1);
  EXPECT_EQ(MakeLap(world, 0, kTurn, 1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(MakeLap(world, 60, 0, 1).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isthmus::simulation
