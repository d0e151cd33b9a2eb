// Surfaces of submaps that are made of nothing but scattered points.
#include "server/matching/registration/surface.h"

#include <gtest/gtest.h>

#include <random>
#include <stop_token>

#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

// In a cube of 60 m: nearly each is alone in its voxel, and has neighbours enough for a normal.
Submap Scattered(size_t count) {
  Submap submap;
  submap.keyframes.resize(1);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> anywhere(-30, 30);
  for (size_t i = 0; i < count; ++i) {
    SubmapPoint& point = submap.points.emplace_back();
    point.x = anywhere(random);
    point.y = anywhere(random);
    point.z = anywhere(random);
  }
  return submap;
}

TEST(SurfaceTest, OfMillionsOfScatteredPointsAFewAreLookedAt) {
  const size_t surface = SampleSurface(Scattered(3 * kMaxSurfaceVoxels), 0.5).size();
  EXPECT_GT(surface, kMaxSurfaceVoxels / 2);
  EXPECT_LE(surface, kMaxSurfaceVoxels);
}

TEST(SurfaceTest, WhatIsLookedAtIsSpreadOverTheWhole) {
  int quarters[4] = {};
  for (const SurfacePoint& point : SampleSurface(Scattered(2 * kMaxSurfaceVoxels), 0.5)) {
    ++quarters[(point.position.x() > 0 ? 2 : 0) + (point.position.y() > 0 ? 1 : 0)];
  }
  for (const int quarter : quarters) EXPECT_GT(quarter, quarters[0] * 9 / 10);
}

TEST(SurfaceTest, IsGivenUpOnceToldToStop) {
  std::stop_source stop;
  const Submap submap = Scattered(20'000);
  EXPECT_FALSE(SampleSurface(submap, 2.0, stop.get_token()).empty());
  stop.request_stop();
  EXPECT_TRUE(SampleSurface(submap, 2.0, stop.get_token()).empty());
}

}  // namespace
}  // namespace isthmus::matching
