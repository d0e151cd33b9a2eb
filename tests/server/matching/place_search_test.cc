#include "server/matching/search/place_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/geometry/angles.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// The places of all submaps, the level known.
std::vector<Place> Describe(const SessionMap& map, const Pose& T_world_odom) {
  std::vector<Place> places;
  for (const auto& submap : map.submaps) {
    for (Place& place : DescribePlaces(*submap, T_world_odom.rotation())) {
      places.push_back(std::move(place));
    }
  }
  return places;
}

// Two robots that cross each other's way in a gallery, one of them with its sensor at a slant.
class PlaceSearchTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.6, -0.3, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.1, 0.05, -2.0); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    map_a_ = Survey(
        scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 20), T_world_a(), 0.01, 1});
    map_b_ = Survey(
        scene, {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 20), T_world_b(), 0.01, 2});
    places_a_ = Describe(map_a_, T_world_a());
    places_b_ = Describe(map_b_, T_world_b());
  }

  static inline SessionMap map_a_, map_b_;
  static inline std::vector<Place> places_a_, places_b_;
};

TEST_F(PlaceSearchTest, PlacesAreLevelAndAtTheSensor) {
  ASSERT_EQ(places_a_.size(), 12u);
  const Submap& submap = *map_a_.submaps[0];
  const auto places = DescribePlaces(submap, T_world_a().rotation(), {}, 1);
  ASSERT_EQ(places.size(), 1u);
  const Eigen::Vector3d middle =
      submap.T_odom_submap * submap.keyframes[2].T_submap_sensor.translation();
  EXPECT_LT((places[0].T_odom_place.translation() - middle).norm(), 1e-9);
  const Eigen::Vector3d up =
      T_world_a().rotation() * (places[0].T_odom_place.rotation() * Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(up.z(), 1, 1e-9);
  EXPECT_EQ(DescribePlaces(submap, T_world_a().rotation(), {}, 99).size(), submap.keyframes.size());
}

TEST_F(PlaceSearchTest, TheRightPlacementIsAmongTheFirst) {
  const auto candidates = SearchPlaces(places_a_, places_b_, 5);
  ASSERT_FALSE(candidates.empty());
  const Eigen::Vector3d crossing = T_world_b().Inverse() * Eigen::Vector3d(13, 6, 1);
  bool found = false;
  for (const Candidate& candidate : candidates) {
    const double shift = (candidate.T_a_b * crossing - T_a_b() * crossing).norm();
    found |= shift < 2.5 && RotationAngle(candidate.T_a_b.Inverse() * T_a_b()) < 12 * kRadPerDeg;
  }
  EXPECT_TRUE(found);
}

TEST_F(PlaceSearchTest, AMapIsFoundOnItself) {
  const auto candidates = SearchPlaces(places_a_, places_a_, 1);
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_LT(candidates[0].T_a_b.translation().norm(), 1e-6);
  EXPECT_LT(RotationAngle(candidates[0].T_a_b), 1e-6);
  EXPECT_NEAR(candidates[0].score, 1, 1e-5);
  EXPECT_EQ(candidates[0].source, GuessSource::kPlaces);
}

TEST_F(PlaceSearchTest, CandidatesAreOrderedDistinctAndLimited) {
  const auto all = SearchPlaces(places_a_, places_b_, 100);
  ASSERT_GT(all.size(), 3u);
  for (size_t i = 1; i < all.size(); ++i) EXPECT_LE(all[i].score, all[i - 1].score);
  for (size_t i = 0; i < all.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Pose between = all[i].T_a_b.Inverse() * all[j].T_a_b;
      EXPECT_TRUE(between.translation().norm() > 0.1 || RotationAngle(between) > 1 * kRadPerDeg);
    }
  }
  EXPECT_EQ(SearchPlaces(places_a_, places_b_, 3).size(), 3u);
  EXPECT_TRUE(SearchPlaces(places_a_, places_b_, 0).empty());
  EXPECT_TRUE(SearchPlaces({}, places_b_, 3).empty());
  EXPECT_TRUE(SearchPlaces(places_a_, {}, 3).empty());
}

TEST_F(PlaceSearchTest, ASubmapWithoutPointsIsNoPlaceToGo) {
  Submap empty = *map_b_.submaps[0];
  empty.points.clear();
  const auto places = DescribePlaces(empty, T_world_b().rotation());
  EXPECT_EQ(places.size(), 3u);
  EXPECT_TRUE(SearchPlaces(places_a_, places, 3).empty());
}

}  // namespace
}  // namespace isthmus::matching
