#include "server/matching/search/place_descriptor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/geometry/angles.h"
#include "core/pose.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

constexpr double kSector = 6 * kRadPerDeg;

// The view of a sensor that stands at `from` and looks along `yaw`.
std::vector<Eigen::Vector3f> LookFrom(const Eigen::Vector3d& from, double yaw, unsigned seed) {
  static const Scene scene = MakeGallery();
  const SessionMap map = Survey(
      scene, {{from}, Pose::FromXyzRpy(from.x(), from.y(), from.z(), 0, 0, yaw), 0.01, seed});
  // The odom frame is the drive's, whatever frame the submap has.
  std::vector<Eigen::Vector3f> points;
  const Pose& T_odom_submap = map.submaps[0]->T_odom_submap;
  for (const SubmapPoint& point : map.submaps[0]->points) {
    points.push_back((T_odom_submap * point.Position().cast<double>()).cast<float>());
  }
  return points;
}

PlaceDescriptor DescribeFrom(const Eigen::Vector3d& from, double yaw = 0, unsigned seed = 1) {
  return DescribePlace(LookFrom(from, yaw, seed));
}

const std::vector<Eigen::Vector3d> kPlaces = {{3, 3, 1},   {8, 6, 1},   {16, 6, 1},
                                              {23, 4, 1},  {27, 8, 1},  {3, 14, 1},
                                              {10, 16, 1}, {17, 14, 1}, {27, 15, 1}};

std::vector<PlaceDescriptor> DescribeAll() {
  std::vector<PlaceDescriptor> all;
  for (const Eigen::Vector3d& place : kPlaces) all.push_back(DescribeFrom(place));
  return all;
}

TEST(PlaceDescriptorTest, IsOfUnitLengthAndNotNegative) {
  const PlaceDescriptor place = DescribeFrom({8, 6, 1});
  double sum = 0;
  for (const float cell : place.cells) {
    EXPECT_GE(cell, 0);
    sum += cell * cell;
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  for (const float key : place.ring_key) {
    EXPECT_GE(key, 0);
    EXPECT_LE(key, 1);
  }
}

TEST(PlaceDescriptorTest, ComparesEqualToItself) {
  const PlaceDescriptor place = DescribeFrom({8, 6, 1});
  const PlaceComparison comparison = Compare(place, place);
  EXPECT_NEAR(comparison.distance, 0, 1e-5);
  EXPECT_EQ(comparison.yaw, 0);
}

TEST(PlaceDescriptorTest, FindsTheTurnBetweenTwoLooks) {
  const double yaw_a = 0.3;
  const PlaceDescriptor a = DescribeFrom({8, 6, 1}, yaw_a, 1);
  for (double yaw_b = -3; yaw_b < 3.2; yaw_b += 0.41) {
    const PlaceDescriptor b = DescribeFrom({8, 6, 1}, yaw_b, 2);
    const PlaceComparison a_b = Compare(a, b), b_a = Compare(b, a);
    EXPECT_LT(a_b.distance, 0.1);
    // R_a_b = R_world_a^-1 R_world_b.
    EXPECT_LE(std::abs(std::remainder(a_b.yaw - (yaw_b - yaw_a), 2 * M_PI)), 0.75 * kSector);
    EXPECT_LE(std::abs(std::remainder(a_b.yaw + b_a.yaw, 2 * M_PI)), 1e-9);
    EXPECT_NEAR(a_b.distance, b_a.distance, 1e-5);
    EXPECT_GT(a_b.yaw, -M_PI);
    EXPECT_LE(a_b.yaw, M_PI + 1e-9);
  }
}

TEST(PlaceDescriptorTest, TellsPlacesApartFromMetresOff) {
  const std::vector<PlaceDescriptor> places = DescribeAll();
  const Eigen::Vector3d shift(0.9, -0.8, 0);
  for (size_t i = 0; i < kPlaces.size(); ++i) {
    const double yaw = 0.7 * static_cast<double>(i);
    const auto hits = FindPlaces(DescribeFrom(kPlaces[i] + shift, yaw, 2), places, 3);
    ASSERT_EQ(hits.size(), 3u);
    EXPECT_EQ(hits[0].place, i);
    // The shift alone turns the bearing of a wall 5 m off by up to 13.5 degrees.
    EXPECT_LE(std::abs(std::remainder(hits[0].comparison.yaw + yaw, 2 * M_PI)), 13.5 * kRadPerDeg);
    EXPECT_LE(hits[0].comparison.distance, hits[1].comparison.distance);
    EXPECT_LE(hits[1].comparison.distance, hits[2].comparison.distance);
  }
}

TEST(PlaceDescriptorTest, OnlyTheBandAndTheRangeCount) {
  std::vector<Eigen::Vector3f> points = LookFrom({8, 6, 1}, 0, 1);
  const PlaceDescriptor before = DescribePlace(points);
  for (float x = -50; x < 50; x += 0.5f) {
    points.emplace_back(x, 3.0f, -0.31f);
    points.emplace_back(x, 3.0f, 2.71f);
    points.emplace_back(x, 61.0f, 1.0f);
  }
  const PlaceDescriptor after = DescribePlace(points);
  EXPECT_EQ(before.cells, after.cells);
  EXPECT_EQ(before.ring_key, after.ring_key);
}

TEST(PlaceDescriptorTest, NeitherOrderNorNonFinitePointsMatter) {
  std::vector<Eigen::Vector3f> points = LookFrom({8, 6, 1}, 0, 1);
  const PlaceDescriptor before = DescribePlace(points);
  std::shuffle(points.begin(), points.end(), std::mt19937(5));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, infinity, -infinity}) {
    points.emplace_back(bad, 1, 1);
    points.emplace_back(1, bad, 1);
    points.emplace_back(1, 1, bad);
  }
  EXPECT_EQ(before.cells, DescribePlace(points).cells);
}

TEST(PlaceDescriptorTest, TheHighestPointOfACellCounts) {
  PlaceDescriptorOptions options;
  options.low_m = 0;
  options.high_m = 4;
  const Eigen::Vector3f low(10, 1, 1), high(10, 1, 3);
  const PlaceDescriptor both = DescribePlace({low, high}, options);
  EXPECT_EQ(both.cells, DescribePlace({high}, options).cells);
  EXPECT_NEAR(both.ring_key[3], 3 * DescribePlace({low}, options).ring_key[3], 1e-6);
}

TEST(PlaceDescriptorTest, NothingIsLikeNothing) {
  const PlaceDescriptor nothing = DescribePlace({}), place = DescribeFrom({8, 6, 1});
  EXPECT_TRUE(nothing.empty());
  EXPECT_FALSE(place.empty());
  EXPECT_EQ(Compare(nothing, place).distance, 1);
  EXPECT_EQ(Compare(nothing, nothing).distance, 1);
  EXPECT_TRUE(FindPlaces(nothing, {place, place}, 2).empty());
  EXPECT_TRUE(FindPlaces(place, {}, 2).empty());
  const auto hits = FindPlaces(place, {nothing, place, nothing}, 5);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].place, 1u);
}

TEST(PlaceDescriptorTest, AtMostKAreReturnedEqualOnesInOrder) {
  const PlaceDescriptor place = DescribeFrom({8, 6, 1});
  const std::vector<PlaceDescriptor> places(7, place);
  EXPECT_TRUE(FindPlaces(place, places, 0).empty());
  std::vector<size_t> found;
  for (const PlaceHit& hit : FindPlaces(place, places, 4)) found.push_back(hit.place);
  EXPECT_THAT(found, ::testing::ElementsAre(0, 1, 2, 3));
}

// The right one is far down the list of places but near in its ring key.
TEST(PlaceDescriptorTest, TheRingKeyFindsOneAmongMany) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> anywhere(-50, 50), height(0, 2.5f);
  std::vector<PlaceDescriptor> places;
  for (int i = 0; i < 400; ++i) {
    std::vector<Eigen::Vector3f> clutter;
    for (int j = 0; j < 10 + i; ++j) {
      clutter.emplace_back(anywhere(rng), anywhere(rng), height(rng));
    }
    places.push_back(DescribePlace(clutter));
  }
  places.push_back(DescribeFrom({8, 6, 1}, 0, 1));
  const auto hits = FindPlaces(DescribeFrom({8.5, 6, 1}, 2, 2), places, 1);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].place, 400u);
}

}  // namespace
}  // namespace isthmus::matching
