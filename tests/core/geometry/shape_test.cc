#include "core/geometry/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace isthmus {
namespace {

constexpr double kPiD = std::numbers::pi;

Eigen::Vector3d RandomPoint(std::mt19937* rng, double extent) {
  std::uniform_real_distribution<double> at(-extent, extent);
  return {at(*rng), at(*rng), at(*rng)};
}

// The polygon surrounds the point an odd number of times: the turns of its corners around it,
// summed up as angles.
bool IsSurrounded(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& p) {
  double turned = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i] - p, b = corners[(i + 1) % corners.size()] - p;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::lround(turned / (2 * kPiD)) % 2 != 0;
}

// The distance to the path seen from above and the height above its nearest place, found by walking
// along it in small steps.
bool IsAlong(const std::vector<Eigen::Vector3d>& path, double width_m, const HeightBand& heights,
             const Eigen::Vector3d& p, double* margin) {
  *margin = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (size_t i = 0; i + 1 < std::max<size_t>(path.size(), 2); ++i) {
    const Eigen::Vector3d from = path[i], to = path[std::min(i + 1, path.size() - 1)];
    double nearest = std::numeric_limits<double>::infinity(), height = 0;
    for (int step = 0; step <= 300; ++step) {
      const Eigen::Vector3d at = from + (to - from) * (step / 300.0);
      const double distance = (p - at).head<2>().norm();
      if (distance >= nearest) continue;
      nearest = distance;
      height = p.z() - at.z();
    }
    inside = inside || (nearest <= width_m / 2 && heights.Contains(height));
    *margin = std::min({*margin, std::abs(nearest - width_m / 2), std::abs(height - heights.min_m),
                        std::abs(height - heights.max_m)});
  }
  return inside;
}

// A shape's answer for a box must be true of the points in it.
void ExpectHonestBoxes(const Shape& shape, std::mt19937* rng) {
  std::uniform_real_distribution<double> share(0, 1);
  for (int round = 0; round < 300; ++round) {
    Box box;
    const Eigen::Vector3d corner = RandomPoint(rng, 12);
    box.Extend(corner);
    box.Extend(Eigen::Vector3d(corner + RandomPoint(rng, round % 2 == 0 ? 6 : 0.6)));
    const bool may_touch = shape.MayTouch(box), contains_all = shape.ContainsAll(box);
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d shares(share(*rng), share(*rng), share(*rng));
      const Eigen::Vector3d p = box.min + shares.cwiseProduct(box.max - box.min);
      const bool inside = shape.Contains(p);
      ASSERT_TRUE(may_touch || !inside);
      ASSERT_TRUE(inside || !contains_all);
    }
  }
}

TEST(ShapeTest, AnOrientedBoxIsABoxInItsOwnFrame) {
  std::mt19937 rng(1);
  const Pose T_map_box = Pose::FromXyzRpy(1, -2, 0.5, 0.3, -0.4, 2);
  const OrientedBoxShape shape(T_map_box, {8, 4, 3});
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p = RandomPoint(&rng, 8);
    const Eigen::Vector3d in_box = T_map_box.Inverse() * p;
    const bool expected =
        std::abs(in_box.x()) <= 4 && std::abs(in_box.y()) <= 2 && std::abs(in_box.z()) <= 1.5;
    ASSERT_EQ(shape.Contains(p), expected);
    inside += expected ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
  ExpectHonestBoxes(shape, &rng);
}

TEST(ShapeTest, APolygonHoldsWhatItSurroundsAnOddNumberOfTimes) {
  std::mt19937 rng(2);
  for (int corners = 3; corners < 12; ++corners) {
    std::vector<Eigen::Vector2d> polygon;
    for (int i = 0; i < corners; ++i) polygon.emplace_back(RandomPoint(&rng, 9).head<2>());
    const HeightBand heights{-2, 5};
    const PolygonShape shape(polygon, heights);
    for (int i = 0; i < 4000; ++i) {
      const Eigen::Vector3d p = RandomPoint(&rng, 10);
      ASSERT_EQ(shape.Contains(p), IsSurrounded(polygon, p.head<2>()) && p.z() >= -2 && p.z() <= 5);
    }
    ExpectHonestBoxes(shape, &rng);
  }
}

TEST(ShapeTest, TheEdgeOfAPolygonBelongsToIt) {
  const PolygonShape square({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, {});
  for (const double along : {0.0, 0.5, 2.0}) {
    EXPECT_TRUE(square.Contains({along, 0, 100}));
    EXPECT_TRUE(square.Contains({along, 2, -1e6}));
    EXPECT_TRUE(square.Contains({0, along, 0}));
    EXPECT_TRUE(square.Contains({2, along, 0}));
  }
  EXPECT_FALSE(square.Contains({2.0000001, 1, 0}));
  EXPECT_TRUE(square.ContainsAll(Box{{0.5, 0.5, -3}, {1.5, 1.5, 3}}));
}

TEST(ShapeTest, ACorridorFollowsItsPath) {
  std::mt19937 rng(3);
  for (const size_t points : {1u, 2u, 3u, 6u}) {
    std::vector<Eigen::Vector3d> path;
    for (size_t i = 0; i < points; ++i) path.push_back(RandomPoint(&rng, 8));
    const HeightBand heights{-1, 2};
    const CorridorShape shape(path, 6, heights);
    int inside = 0;
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3d p = RandomPoint(&rng, 10);
      double margin = 0;
      const bool expected = IsAlong(path, 6, heights, p, &margin);
      // Steps along the path are up to 0.1 m.
      if (margin > 0.15) {
        ASSERT_EQ(shape.Contains(p), expected);
      }
      inside += expected ? 1 : 0;
    }
    EXPECT_GT(inside, 5);
    ExpectHonestBoxes(shape, &rng);
  }
}

// A ramp that winds above itself: each storey has its own heights.
TEST(ShapeTest, ACorridorThatCrossesItselfHasBothHeights) {
  const CorridorShape shape({{-5, 0, 0}, {5, 0, 0}, {5, 5, 3}, {0, 5, 6}, {0, -5, 6}}, 2, {0, 1.5});
  EXPECT_TRUE(shape.Contains({0, 0, 1}));
  EXPECT_TRUE(shape.Contains({0, 0, 7}));
  EXPECT_FALSE(shape.Contains({0, 0, 3}));
}

}  // namespace
}  // namespace isthmus
