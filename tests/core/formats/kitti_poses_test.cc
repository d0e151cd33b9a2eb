#include "core/formats/kitti_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/formats/tum.h"

namespace isthmus::formats {
namespace {

TEST(KittiPoses, RowsOfTheMatrix) {
  const auto poses = ParseKittiPoses(
      "1 0 0 0 0 1 0 0 0 0 1 0\n"
      "0.000000e+00 -1 0 5 1 0 0 6 0 0 1 7\n");
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[1].translation(), Eigen::Vector3d(5, 6, 7));
  EXPECT_NEAR((*poses)[1].Yaw(), std::acos(0.0), 1e-12);
}

TEST(KittiPoses, SaysWhichLineIsWrong) {
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  for (const char* bad : {"1 0 0 0 0 1 0 0 0 0 1\n", "1 0 0 0 0 1 0 0 0 0 1 x\n",
                          "1 0 0 nan 0 1 0 0 0 0 1 0\n", "1 0 0 1e308 0 1 0 0 0 0 1 0\n",
                          "2 0 0 0 0 2 0 0 0 0 2 0\n", "1 0 0 0 0 1 0 0 0 0 -1 0\n"}) {
    const auto poses = ParseKittiPoses(good + bad);
    EXPECT_EQ(poses.status().code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(poses.status().message()), testing::HasSubstr("line 2")) << bad;
  }
}

TEST(TumPoses, BeyondAnyPlaceOnEarthAreRefused) {
  const auto poses = ParseTum("1 0 0 0 0 0 0 1\n2 0 -1e308 0 0 0 0 1\n");
  EXPECT_EQ(poses.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(poses.status().message()), testing::HasSubstr("line 2: '-1e308'"));
}

TEST(KittiPoses, AreToldFromTumByTheirColumns) {
  EXPECT_TRUE(LooksLikeKittiPoses("# poses\n\n1 0 0 0 0 1 0 0 0 0 1 0\n"));
  EXPECT_FALSE(LooksLikeKittiPoses("100.0 0 0 0 0 0 0 1\n"));
  EXPECT_FALSE(LooksLikeKittiPoses(""));
}

}  // namespace
}  // namespace isthmus::formats
