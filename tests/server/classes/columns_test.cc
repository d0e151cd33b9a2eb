#include "server/classes/columns.h"

#include <gtest/gtest.h>

#include "tests/server/classes/clouds.h"

namespace isthmus::classes {
namespace {

TEST(ColumnsTest, ARunIsThePartWithoutAGap) {
  Cloud3 cloud = Joined({RoomFloor(), RoomCeiling()});
  AddBox({5, 5, 0}, {1, 1, 1}, &cloud);
  const GroundGrid ground(cloud, RoomSensors());
  const Columns columns(cloud, ground);
  const Stretch run = columns.StretchAt({5.05F, 5.5F, 0.5F});
  EXPECT_NEAR(run.bottom_m, 0, 0.21);
  EXPECT_NEAR(run.top_m, 1, 0.21);
  EXPECT_NEAR(run.top_of_all_m, 3, 0.21);
  EXPECT_GE(run.above, 1);
}

TEST(ColumnsTest, ACourseIsAsLargeAsWhatStands) {
  Cloud3 cloud = RoomFloor();
  AddBox({4, 5.5F, 0}, {4, 1.6F, 1.5F}, &cloud);
  AddBox({1, 1, 0}, {0.4F, 0.4F, 1.8F}, &cloud);
  const GroundGrid ground(cloud, RoomSensors());
  const Columns columns(cloud, ground);
  const Course* car = columns.CourseAt({4.05F, 6, 1});
  const Course* post = columns.CourseAt({1, 1.2F, 1});
  ASSERT_NE(car, nullptr);
  ASSERT_NE(post, nullptr);
  EXPECT_NE(car, post);
  EXPECT_NEAR(car->top_m, 1.5, 0.3);
  EXPECT_GT(car->length_m, 3.5F);
  EXPECT_LT(post->length_m, 1.5F);
  EXPECT_EQ(columns.CourseAt({10, 4, 0}), nullptr);
}

TEST(ColumnsTest, AWallStandsInOneLine) {
  const Cloud3 room = Joined({RoomFloor(), RoomWalls()});
  const GroundGrid ground(room, RoomSensors());
  const Columns columns(room, ground);
  EXPECT_GT(columns.At({6, 0, 1}).along, 0.8F);
}

TEST(ColumnsTest, WhatIsHigherThanAllBinsIsInTheHighest) {
  Cloud3 tower = RoomFloor();
  for (float z = 0; z < 40; z += 0.1F) tower.push_back({6, 6, z});
  const GroundGrid ground(tower, RoomSensors());
  const Columns columns(tower, ground);
  const Stretch run = columns.StretchAt({6, 6, 39});
  EXPECT_NEAR(run.top_m, kLowestBinM + kBins * kBinM, 1e-3);
  EXPECT_EQ(run.above, 0);
}

}  // namespace
}  // namespace isthmus::classes
