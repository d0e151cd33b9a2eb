#include "client/simulation/lidar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

namespace isthmus::simulation {
namespace {

class EveryLidar : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryLidar, FiresOnceAroundClockwiseFromTheBack) {
  const Lidar lidar = *MakeLidar(GetParam());
  ASSERT_EQ(lidar.firings.size() % lidar.lasers, 0u);
  double before = -1;
  for (const Firing& firing : lidar.firings) {
    ASSERT_GE(firing.time_s, before);
    ASSERT_LT(firing.time_s, lidar.period_s);
    ASSERT_NEAR(firing.direction.norm(), 1, 1e-6);
    before = firing.time_s;
  }
  const auto azimuth = [&](double share) {
    const auto i = static_cast<size_t>(share * static_cast<double>(lidar.firings.size()));
    return std::atan2(lidar.firings[i].direction.y(), lidar.firings[i].direction.x());
  };
  EXPECT_NEAR(std::abs(azimuth(0)), std::numbers::pi, 0.01);
  EXPECT_NEAR(azimuth(0.25), std::numbers::pi / 2, 0.02);  // Left first: clockwise from the back.
  EXPECT_NEAR(azimuth(0.5), 0, 0.02);
  EXPECT_NEAR(azimuth(0.75), -std::numbers::pi / 2, 0.02);
}

TEST_P(EveryLidar, RingsAscendFromTheLowest) {
  const Lidar lidar = *MakeLidar(GetParam());
  std::map<uint16_t, float> height;
  for (size_t i = 0; i < lidar.lasers; ++i) {
    height[lidar.firings[i].ring] = lidar.firings[i].direction.z();
  }
  ASSERT_EQ(height.size(), lidar.lasers);
  EXPECT_EQ(height.begin()->first, 0);
  float before = -1;
  for (const auto& [ring, z] : height) {
    EXPECT_GT(z, before) << ring;
    before = z;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, EveryLidar, ::testing::ValuesIn(LidarNames()),
                         [](const auto& test) {
                           return test.param == "os1-64" ? "os1_64" : test.param;
                         });

TEST(Lidar, Vlp16IsAsInItsManual) {
  const Lidar lidar = *MakeLidar("vlp16");
  EXPECT_EQ(lidar.firings.size(), 1808u * 16);
  EXPECT_NEAR(std::asin(lidar.firings[0].direction.z()) * 180 / std::numbers::pi, -15, 1e-4);
  EXPECT_NEAR(std::asin(lidar.firings[1].direction.z()) * 180 / std::numbers::pi, 1, 1e-4);
  EXPECT_DOUBLE_EQ(lidar.firings[17].time_s, 55.296e-6 + 2.304e-6);
}

TEST(Lidar, UnknownModelListsTheKnownOnes) {
  const auto lidar = MakeLidar("radar");
  EXPECT_EQ(lidar.status().code(), absl::StatusCode::kInvalidArgument);
  for (const std::string& name : LidarNames()) {
    EXPECT_NE(std::string(lidar.status().message()).find(name), std::string::npos);
  }
}

}  // namespace
}  // namespace isthmus::simulation
