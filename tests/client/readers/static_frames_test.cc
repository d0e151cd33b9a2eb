// Mountings that a recording tells.
#include "client/readers/static_frames.h"

#include <gtest/gtest.h>

#include <numbers>

namespace isthmus::readers {
namespace {

Pose At(double x, double y, double z, double yaw = 0) {
  return Pose::FromXyzRpy(x, y, z, 0, 0, yaw);
}

// base_footprint -> base_link -> {mast -> lidar, gps}
const StaticFrames& Robot() {
  static const StaticFrames frames({{"base_footprint", "r1/base_link", At(0, 0, 0.2)},
                                    {"r1/base_link", "mast", At(1, 0, 0.5)},
                                    {"/mast", "lidar", At(0, 0, 1, std::numbers::pi / 2)},
                                    {"r1/base_link", "gps", At(-1, 0, 1)}});
  return frames;
}

TEST(StaticFrames, AFrameIsSeenFromAnyOtherOfItsTree) {
  const auto lidar = Robot().Between("r1/base_link", "lidar");
  ASSERT_TRUE(lidar);
  EXPECT_TRUE(lidar->translation().isApprox(Eigen::Vector3d(1, 0, 1.5), 1e-12));
  EXPECT_NEAR(lidar->Yaw(), std::numbers::pi / 2, 1e-12);
  const auto gps = Robot().Between("lidar", "gps");
  ASSERT_TRUE(gps);
  // 2 m behind the lidar, whose x points to the robot's left, and 0.5 m below.
  EXPECT_TRUE(gps->translation().isApprox(Eigen::Vector3d(0, 2, -0.5), 1e-12))
      << gps->translation();
  EXPECT_TRUE((*gps * *Robot().Between("gps", "lidar")).Matrix().isIdentity(1e-12));
  EXPECT_TRUE(Robot().Between("lidar", "/lidar")->Matrix().isIdentity(1e-12));
}

TEST(StaticFrames, FramesThatNothingJoinsAreNotRelated) {
  EXPECT_FALSE(Robot().Between("lidar", "camera"));
  EXPECT_FALSE(Robot().Between("", "lidar"));
  EXPECT_FALSE(Robot().Between("lidar", ""));
}

TEST(StaticFrames, TheBaseIsBaseLinkBeforeBaseFootprint) {
  EXPECT_EQ(Robot().BaseOf("lidar"), "r1/base_link");
  EXPECT_EQ(Robot().BaseOf("base_footprint"), "base_footprint");
  EXPECT_EQ(Robot().BaseOf("camera"), "");
  const StaticFrames other({{"my_base_link", "lidar", At(0, 0, 1)}});
  EXPECT_EQ(other.BaseOf("lidar"), "") << "only the whole last part of a name counts";
}

TEST(StaticFrames, ACycleEnds) {
  const StaticFrames cycle({{"a", "b", At(1, 0, 0)}, {"b", "a", At(1, 0, 0)}});
  EXPECT_EQ(cycle.BaseOf("a"), "");
  EXPECT_TRUE(cycle.Between("a", "b"));
  EXPECT_FALSE(cycle.Between("a", "c"));
}

}  // namespace
}  // namespace isthmus::readers
