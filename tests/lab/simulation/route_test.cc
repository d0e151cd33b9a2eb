#include "lab/simulation/route.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "lab/simulation/sensors/ray_caster.h"

namespace isthmus::simulation {
namespace {

TEST(ClosedCurve, OfACirclesPointsIsNearlyACircle) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2 * std::numbers::pi * i / 40;
    points.push_back(10 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  const ClosedCurve curve(points);
  EXPECT_NEAR(curve.length(), 2 * std::numbers::pi * 10, 0.5);
  for (double s = 0; s < 2 * curve.length(); s += 0.37) {
    const auto at = curve.At(s);
    EXPECT_NEAR(at.position.norm(), 10, 0.1);
    EXPECT_NEAR(at.curvature, 0.1, 0.005);
    // The argument is the length: a small step moves by as much.
    EXPECT_NEAR((curve.At(s + 1e-3).position - at.position).norm(), 1e-3, 1e-6);
  }
}

TEST(SpeedProfile, KeepsToItsLimits) {
  std::vector<Eigen::Vector2d> square;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d corners[] = {{0, 0}, {14, 0}, {14, 14}, {0, 14}, {0, 0}};
      square.push_back(corners[side] + (corners[side + 1] - corners[side]) * i / 20.0);
    }
  }
  const ClosedCurve curve(square);
  const SpeedLimits limits;
  const SpeedProfile profile(curve, limits, 100);
  EXPECT_EQ(profile.At(0).speed_mps, 0);
  double fastest = 0;
  for (double t = 0.01; t < 100; t += 0.01) {
    const auto before = profile.At(t - 0.01), state = profile.At(t);
    ASSERT_GT(state.s, before.s);
    ASSERT_LE(std::abs(state.speed_mps - before.speed_mps), limits.acceleration_mps2 * 0.01 + 1e-9);
    ASSERT_LE(state.speed_mps, limits.speed_mps + 1e-9);
    const double bend = std::abs(curve.At(state.s).curvature);
    ASSERT_LE(state.speed_mps * bend, limits.yaw_rate_radps * 1.02);
    fastest = std::max(fastest, state.speed_mps);
  }
  EXPECT_NEAR(fastest, limits.speed_mps, 1e-6);
}

TEST(MakeRoutes, RefusesNoRobotsAndNoTime) {
  const World world = *MakeWorld("museum", 1);
  EXPECT_EQ(MakeRoutes(world, 0, 60, 1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(MakeRoutes(world, 1, 0, 1).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(MakeRoutes(world, 1, NAN, 1).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(MakeRoutes, ChangesWithTheSeedOnly) {
  const World world = *MakeWorld("museum", 1);
  const auto first = *MakeRoutes(world, 1, 60, 1), again = *MakeRoutes(world, 1, 60, 1);
  const auto other = *MakeRoutes(world, 1, 60, 2);
  EXPECT_EQ(first[0](33).Matrix(), again[0](33).Matrix());
  EXPECT_GT((first[0](33).translation() - other[0](33).translation()).norm(), 0.05);
}

class EveryRoute : public ::testing::TestWithParam<std::tuple<std::string, uint64_t>> {};

TEST_P(EveryRoute, IsSmooth) {
  const auto [name, seed] = GetParam();
  const World world = *MakeWorld(name, seed);
  const auto motions = *MakeRoutes(world, 4, 100, seed);
  ASSERT_EQ(motions.size(), 4u);
  constexpr double kStep = 0.01;
  for (const Motion& motion : motions) {
    Vector6d before = Vector6d::Zero();  // At rest.
    for (double t = 0; t < 100; t += kStep) {
      const Vector6d twist = Log(motion(t).Inverse() * motion(t + kStep)) / kStep;
      ASSERT_LT(twist.head<3>().norm(), world.max_speed_mps * 1.1);
      ASSERT_LT(twist.tail<3>().norm(), 1.0);  // rad/s
      // No jumps of velocity or yaw rate: their change in 10 ms is bounded.
      ASSERT_LT((twist - before).head<3>().norm(), 0.05) << t;
      ASSERT_LT((twist - before).tail<3>().norm(), 0.15) << t;
      before = twist;
    }
  }
}

TEST_P(EveryRoute, IsLongAndTouchesNothing) {
  const auto [name, seed] = GetParam();
  const World world = *MakeWorld(name, seed);
  const RayCaster caster(world.mesh);
  std::vector<Ray> rays(64);
  std::vector<Hit> hits(64);
  const auto motions = *MakeRoutes(world, 4, 200, seed);
  for (const Motion& motion : motions) {
    double length = 0, nearest = 100;
    for (double t = 0; t < 200; t += 0.2) {
      const Eigen::Vector3d at = motion(t).translation();
      length += (motion(t + 0.2).translation() - at).norm();
      for (int i = 0; i < 64; ++i) {
        const float azimuth = static_cast<float>(i) * 0.0982f;
        // At the sensor's height and at the height of a robot's body.
        const Eigen::Vector3f origin = (at - Eigen::Vector3d(0, 0, i % 2 * 0.4)).cast<float>();
        rays[i] = {origin, {std::cos(azimuth), std::sin(azimuth), 0}};
      }
      caster.Cast(rays, 100, hits);
      for (const Hit& hit : hits) {
        if (hit.range_m >= 0) nearest = std::min(nearest, double{hit.range_m});
      }
    }
    EXPECT_GT(nearest, 0.45);
    EXPECT_GT(length, 100 * world.max_speed_mps);  // At least half the top speed on average.
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, EveryRoute,
                         ::testing::Combine(::testing::ValuesIn(WorldNames()),
                                            ::testing::Values<uint64_t>(1, 2)),
                         [](const auto& test) {
                           return std::get<0>(test.param) + std::to_string(std::get<1>(test.param));
                         });

}  // namespace
}  // namespace isthmus::simulation
