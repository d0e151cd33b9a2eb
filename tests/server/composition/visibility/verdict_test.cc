#include "server/composition/visibility/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace isthmus::composition {
namespace {

// The side of something two metres long that five keyframes saw, a part each. Others looked through
// its place before, nobody since.
std::vector<WeightedPoint> SideOfACar(int seen_again_one_in) {
  std::vector<WeightedPoint> points;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 10; ++j) {
      WeightedPoint point;
      point.x = 0.1f * static_cast<float>(i) + 0.05f;
      point.z = 0.1f * static_cast<float>(j) + 0.45f;
      point.keyframe = static_cast<uint16_t>(i / 4);
      point.through_before = -24;
      const bool is_seen_again =
          seen_again_one_in > 0 && points.size() % static_cast<size_t>(seen_again_one_in) == 0;
      point.keyframes_after = is_seen_again ? 1 : 0;
      points.push_back(point);
    }
  }
  return points;
}

int64_t CountGone(std::vector<WeightedPoint> points) {
  MarkGone(points, Pose());
  return std::ranges::count_if(points, [](const WeightedPoint& p) { return p.gone; });
}

TEST(MarkGone, WhatCameStaysWhereItWasSeenTwice) { EXPECT_EQ(CountGone(SideOfACar(7)), 0); }

// In sight for as long, and no point of it twice.
TEST(MarkGone, WhoDrivesByLeaves) { EXPECT_EQ(CountGone(SideOfACar(0)), 200); }

// Two metres of it, of which one end was looked through.
TEST(MarkGone, TheRestOfAThingFollowsUnlessItWasSeen) {
  std::vector<WeightedPoint> points = SideOfACar(0);
  for (WeightedPoint& point : points) {
    point.keyframe = 0;
    if (point.x > 0.5f) point.through_before = 0;
  }
  WeightedPoint road;
  road.x = 1;
  points.push_back(road);
  // Three times half a metre on.
  const int64_t gone = CountGone(points);
  EXPECT_GE(gone, 170);
  EXPECT_LE(gone, 200) << "the road stays";
  for (WeightedPoint& point : points) {
    if (point.x > 1) point.other_looks = 8;
  }
  EXPECT_LE(CountGone(points), 100);
}

}  // namespace
}  // namespace isthmus::composition
