#include "floam/map/local_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "floam/map/limits.h"

namespace isthmus::floam {
namespace {

using Eigen::Vector3d;

VoxelSums SumsOf(const std::vector<Eigen::Vector3f>& points) {
  VoxelSums sums;
  for (const Eigen::Vector3f& p : points) sums.Add(p, VoxelSums::kSeveral);
  return sums;
}

// The width does not matter: the surface may bend, or the sensor pitch.
TEST(FitShape, WhatOnlyOneRingCrossedIsNeitherPlaneNorLine) {
  for (const bool several : {false, true}) {
    VoxelSums sums;
    for (int k = 0; k < 40; ++k) {
      const float x = 0.1F * static_cast<float>(k % 5) - 0.2F;
      const float y = 0.06F * static_cast<float>(k / 5) - 0.2F;
      sums.Add({x, y, 0.001F * static_cast<float>(k % 3)}, several && k % 2 == 1 ? 4 : 3);
    }
    EXPECT_EQ(FitShape(sums, ShapeKind::kPlane).valid, several);
    VoxelSums slim;
    for (int k = 0; k < 40; ++k) {
      slim.Add({0.01F * static_cast<float>(k), 0.001F * static_cast<float>(k % 3), 0},
               several && k % 2 == 1 ? 4 : 3);
    }
    EXPECT_EQ(FitShape(slim, ShapeKind::kLine).valid, several);
    // Voxels of one ring each are no shape together, either.
    VoxelSums block;
    block.Add(sums);
    block.Add(VoxelSums());
    block.Add(sums);
    EXPECT_EQ(FitShape(block, ShapeKind::kPlane).valid, several);
  }
}

TEST(FitShape, FindsAPlaneThroughNoise) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> side(-0.25F, 0.25F);
  std::normal_distribution<float> noise(0, 0.01F);
  const Eigen::Vector3f normal = Eigen::Vector3f(1, 2, -2).normalized();
  const Eigen::Vector3f u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < 200; ++k) {
    points.push_back(side(random) * u + side(random) * v + (0.1F + noise(random)) * normal);
  }
  const Shape shape = FitShape(SumsOf(points), ShapeKind::kPlane);
  ASSERT_TRUE(shape.valid);
  EXPECT_GT(std::abs(shape.direction.dot(normal)), 0.999F);
  EXPECT_NEAR(shape.mean.dot(normal), 0.1, 0.003);
  EXPECT_NEAR(std::sqrt(shape.variance), 0.01, 0.002);
  EXPECT_FALSE(FitShape(SumsOf(points), ShapeKind::kLine).valid);
}

// With noise along the rays: thin, though flat.
TEST(FitShape, AStripIsNoPlaneButMayBeALine) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.02F);
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < 40; ++k) {
    points.emplace_back(noise(random), -0.25F + 0.0125F * static_cast<float>(k), 0.001F);
  }
  EXPECT_FALSE(FitShape(SumsOf(points), ShapeKind::kPlane).valid);
  const Shape line = FitShape(SumsOf(points), ShapeKind::kLine);
  ASSERT_TRUE(line.valid);
  EXPECT_GT(std::abs(line.direction.y()), 0.99F);
}

TEST(FitShape, TooFewPointsAreNothing) {
  EXPECT_FALSE(FitShape(SumsOf({{0, 0, 0}, {0.4F, 0, 0}, {0, 0.4F, 0}}), ShapeKind::kPlane).valid);
  EXPECT_FALSE(FitShape(VoxelSums(), ShapeKind::kLine).valid);
}

// A square metre of floor at height z, every 5 cm.
void InsertFloor(double x, double y, double z, LocalMap* map) {
  for (double dx = 0.025; dx < 1; dx += 0.05) {
    for (double dy = 0.025; dy < 1; dy += 0.05) map->Insert({x + dx, y + dy, z});
  }
}

TEST(LocalMap, FindsTheVoxelsPlaneAlsoFarFromTheOrigin) {
  for (const double far : {0.0, -300.0, 50'000.0}) {
    LocalMap map(ShapeKind::kPlane, LocalMapOptions());
    const double corner = far + kGridOriginM;  // A block's corner.
    const double floor = kGridOriginM - 0.73;
    InsertFloor(corner, corner, floor, &map);
    LocalMap::Found found;
    map.Find({corner + 0.2, corner + 0.8, floor + 0.13}, &found);
    ASSERT_NE(found.shape, nullptr) << far;
    EXPECT_GT(std::abs(found.shape->direction.z()), 0.999F);
    EXPECT_NEAR(found.origin.z() + found.shape->mean.z(), floor, 1e-4);
  }
}

TEST(LocalMap, FallsBackToTheBlockAndElseFindsNothing) {
  LocalMap map(ShapeKind::kPlane, LocalMapOptions());
  const Vector3d corner = Vector3d::Constant(kGridOriginM);  // A block's corner.
  InsertFloor(corner.x(), corner.y(), corner.z() + 0.1, &map);
  LocalMap::Found found;
  map.Find(corner + Vector3d(0.3, 0.3, 0.9),
           &found);  // The upper voxels are empty; the block has a floor.
  ASSERT_NE(found.shape, nullptr);
  EXPECT_NEAR(found.origin.z() + found.shape->mean.z(), corner.z() + 0.1, 1e-4);
  map.Find(corner + Vector3d(0.3, 0.3, 1.1), &found);
  EXPECT_EQ(found.shape, nullptr);
}

TEST(LocalMap, ShapesFollowNewPoints) {
  LocalMapOptions options;
  options.max_count = 300;
  LocalMap map(ShapeKind::kPlane, options);
  InsertFloor(0, 0, 0.10, &map);
  LocalMap::Found found;
  map.Find({0.3, 0.3, 0.1}, &found);
  for (int k = 0; k < 30; ++k) InsertFloor(0, 0, 0.14, &map);
  found = LocalMap::Found();
  map.Find({0.3, 0.3, 0.1}, &found);
  ASSERT_NE(found.shape, nullptr);
  EXPECT_NEAR(found.origin.z() + found.shape->mean.z(), 0.14, 0.005);
}

TEST(LocalMap, ForgetsWhatIsFarAndKeepsWhatIsNear) {
  LocalMapOptions options;
  options.radius_m = 20;
  LocalMap map(ShapeKind::kPlane, options);
  size_t most = 0;
  for (int x = 0; x < 400; ++x) {
    for (int y = 0; y < 5; ++y) InsertFloor(x, y, 0.1, &map);
    map.Evict({x + 0.5, 2, 0});
    most = std::max(most, map.block_count());
  }
  EXPECT_LT(most, 200u);
  LocalMap::Found found;
  for (int x = 385; x < 400; ++x) {
    for (int y = 0; y < 5; ++y) {
      map.Find({x + 0.3, y + 0.3, 0.1}, &found);
      EXPECT_NE(found.shape, nullptr) << x << " " << y;
    }
  }
  map.Find({10.3, 2.3, 0.1}, &found);
  EXPECT_EQ(found.shape, nullptr);
}

TEST(LocalMap, ForgetsWhatIsFarishAndWasNotSeenForLong) {
  LocalMapOptions options;
  options.lasting_radius_m = 20;
  options.lasting_scans = 100;
  LocalMap map(ShapeKind::kPlane, options);
  InsertFloor(2, 2, 0.1, &map);
  InsertFloor(40, 2, 0.1, &map);
  InsertFloor(-40, 2, 0.1, &map);
  const auto is_known = [&](double x) {
    LocalMap::Found found;
    map.Find({x + 0.5, 2.5, 0.1}, &found);
    return found.shape != nullptr;
  };
  for (int scan = 0; scan < 250; ++scan) {
    if (scan % 50 == 0) InsertFloor(-40, 2, 0.1, &map);  // Still being seen.
    map.Evict({0, 0, 0});
    if (scan == 90) {
      EXPECT_TRUE(is_known(40));
    }
  }
  EXPECT_TRUE(is_known(2));
  EXPECT_TRUE(is_known(-40));
  EXPECT_FALSE(is_known(40));
}

TEST(LocalMap, StaysWithinItsLimitOfBlocks) {
  LocalMapOptions options;
  options.max_blocks = 300;
  LocalMap map(ShapeKind::kPlane, options);
  for (int round = 0; round < 200; ++round) {
    for (int x = -15; x < 15; ++x) {
      for (int y = -15; y < 15; ++y) map.Insert({x + 0.5, y + 0.5, 0.5});
    }
    for (int k = 0; k < 5; ++k) map.Evict({0, 0, 0});
  }
  EXPECT_LE(map.block_count(), 500u);
  EXPECT_GE(map.block_count(), 100u);
}

}  // namespace
}  // namespace isthmus::floam
