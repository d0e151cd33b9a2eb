#include "floam/scan/scan_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "floam/scan/features.h"
#include "floam/scan/scan_frame.h"
#include "tests/floam/building.h"

namespace isthmus::floam {
namespace {

using testing::Room;

ScanFrame FrameOf(const Room& room, const Pose& T_world_sensor) {
  FrameMaker maker(*FindSensorModel("vlp16"), FeatureOptions());
  ScanFrame frame;
  EXPECT_TRUE(maker.Make(testing::StandingScan(room, T_world_sensor, 0), nullptr, &frame).ok());
  return frame;
}

// A room of 20 x 14 m with a pillar 3 m ahead of the sensor.
Room WithPillar() {
  Room room;
  room.boxes = {{{3, -0.5, -1.2}, {4, 0.5, 3.8}}};
  return room;
}

// The distances of the points on walls from the walls: at most so far for nine in ten, and the
// worst.
struct Misplaced {
  float most = 0, worst = 0;
};
Misplaced Misplacement(const std::vector<Eigen::Vector2f>& walls) {
  std::vector<float> off;
  for (const Eigen::Vector2f& wall : walls) {
    const float outer = std::abs(std::min(10 - std::abs(wall.x()), 7 - std::abs(wall.y())));
    const Eigen::Vector2f nearest =
        wall.cwiseMax(Eigen::Vector2f(3, -0.5F)).cwiseMin(Eigen::Vector2f(4, 0.5F));
    off.push_back(std::min(outer, (wall - nearest).norm()));
  }
  std::sort(off.begin(), off.end());
  return {off[off.size() * 9 / 10], off.back()};
}

TEST(ScanImage, WallsLieOnWallsAndNotOnTheFloor) {
  ScanImage image;
  image.Make(FrameOf(WithPillar(), Pose()).scan);
  const auto walls = image.Walls(Eigen::Matrix3f::Identity(), 0.5F, 25);
  EXPECT_GT(walls.size(), 60u);
  const Misplaced off = Misplacement(walls);
  EXPECT_LT(off.most, 0.06F);
  EXPECT_LT(off.worst, 0.25F);  // Worst at the foot of a wall.
}

TEST(ScanImage, WallsStandUprightAfterTheTiltIsTakenOut) {
  const Pose tilted = Pose::FromXyzRpy(0, 0, 0, 0.12, -0.1, 0);
  ScanImage image;
  image.Make(FrameOf(WithPillar(), tilted).scan);
  const auto walls = image.Walls(tilted.RotationMatrix().cast<float>(), 0.5F, 25);
  EXPECT_GT(walls.size(), 60u);
  const Misplaced off = Misplacement(walls);
  EXPECT_LT(off.most, 0.06F);
  EXPECT_LT(off.worst, 0.25F);  // Worst at the foot of a wall.
}

TEST(ScanImage, LeavesOutWhatIsTooFar) {
  ScanImage image;
  image.Make(FrameOf(WithPillar(), Pose()).scan);
  for (const Eigen::Vector2f& wall : image.Walls(Eigen::Matrix3f::Identity(), 0.5F, 8)) {
    EXPECT_LE(wall.norm(), 8);
  }
}

TEST(ScanImage, TellsThroughFromOntoAndHidden) {
  ScanImage image;
  image.Make(FrameOf(WithPillar(), Pose()).scan);
  EXPECT_EQ(image.SightOf({3, 0, 0.05F}), ScanImage::Sight::kOnto);
  EXPECT_EQ(image.SightOf({2, 0, 0.03F}), ScanImage::Sight::kThrough);
  EXPECT_EQ(image.SightOf({8, 0, 0.14F}), ScanImage::Sight::kHidden);
  EXPECT_EQ(image.SightOf({-5, 0, 0.09F}), ScanImage::Sight::kThrough);
  EXPECT_EQ(image.SightOf({-10, 0, 0.17F}), ScanImage::Sight::kOnto);
  EXPECT_EQ(image.SightOf({0.5F, 0, 3}), ScanImage::Sight::kUnknown);  // Above all rings.
}

TEST(ScanImage, KnowsNothingOfAnEmptyScan) {
  ScanImage image;
  image.Make(RingScan());
  EXPECT_TRUE(image.Walls(Eigen::Matrix3f::Identity(), 0.5F, 25).empty());
  EXPECT_EQ(image.SightOf({3, 0, 0}), ScanImage::Sight::kUnknown);
}

}  // namespace
}  // namespace isthmus::floam
