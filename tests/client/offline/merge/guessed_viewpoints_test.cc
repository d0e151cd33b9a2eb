#include "client/offline/merge/guessed_viewpoints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace isthmus::cli {
namespace {

void AddPlate(float x0, float x1, float y0, float y1, float z, Cloud* cloud) {
  for (float x = x0; x < x1; x += 0.2f) {
    for (float y = y0; y < y1; y += 0.2f) cloud->push_back({x, y, z, 0});
  }
}

TEST(GuessViewpoints, StandOnOpenFloor) {
  Cloud cloud;
  AddPlate(0, 20, 0, 10, -0.8f, &cloud);
  AddPlate(5, 10, 2, 8, 0.2f, &cloud);   // A table, floor under it.
  AddPlate(30, 34, 0, 4, 4.0f, &cloud);  // The upper side of something, with nothing below.
  const Trajectory places = GuessViewpoints(cloud);
  ASSERT_GT(places.size(), 5u);
  for (const StampedPose& place : places) {
    const Eigen::Vector3d& p = place.pose.translation();
    EXPECT_NEAR(p.z(), 0.2, 1e-6);
    EXPECT_LT(p.x(), 20);
    EXPECT_FALSE(p.x() > 5 && p.x() < 10 && p.y() > 2 && p.y() < 8) << "in the table";
  }
}

TEST(GuessViewpoints, StandOnEveryLargeStretchOfTheFloor) {
  Cloud cloud;
  AddPlate(0, 10, 0, 10, 0, &cloud);
  AddPlate(12, 20, 0, 10, 0.2f, &cloud);  // Beyond a gap that no scan ring fell into.
  AddPlate(30, 32, 0, 2, 0, &cloud);      // A corner that was seen through a window.
  int beyond = 0;
  for (const StampedPose& place : GuessViewpoints(cloud)) {
    EXPECT_LT(place.pose.translation().x(), 25);
    beyond += place.pose.translation().x() > 11;
  }
  EXPECT_GT(beyond, 3);
}

TEST(GuessViewpoints, ThereAreNoneWithoutFloor) {
  Cloud wall;
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 20; ++k) wall.push_back({i * 0.02f, 2, k * 0.1f, 1});
  }
  EXPECT_TRUE(GuessViewpoints(wall).empty());
  EXPECT_TRUE(GuessViewpoints({}).empty());
}

TEST(GuessViewpoints, AreNeverMany) {
  Cloud cloud;
  AddPlate(-60, 60, -60, 60, 0, &cloud);
  const Trajectory places = GuessViewpoints(cloud);
  EXPECT_GT(places.size(), 20u);
  EXPECT_LE(places.size(), 64u);
  const auto far = std::count_if(places.begin(), places.end(), [](const StampedPose& place) {
    return place.pose.translation().norm() > 30;
  });
  EXPECT_GT(far, 5) << "spread over all of it";
}

}  // namespace
}  // namespace isthmus::cli
