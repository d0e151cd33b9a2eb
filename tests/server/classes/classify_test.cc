#include "server/classes/classify.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/server/classes/clouds.h"

namespace isthmus::classes {
namespace {

const Eigen::Vector3f kUp(0, 0, 1);

// The share of labels [begin, end) that are of the class.
double ShareOf(const std::vector<PointLabel>& labels, size_t begin, size_t end, PointClass of) {
  size_t count = 0;
  for (size_t i = begin; i < end; ++i) count += labels[i].of == of ? 1 : 0;
  return static_cast<double>(count) / static_cast<double>(end - begin);
}

TEST(ClassifyTest, ARoomHasFloorCeilingAndWalls) {
  const Cloud3 floor = RoomFloor(), ceiling = RoomCeiling();
  const Cloud3 room = Joined({floor, ceiling, RoomWalls()});
  // Lean by 4 degrees, as sensors are mounted.
  const Eigen::Quaternionf lean(Eigen::AngleAxisf(0.07F, Eigen::Vector3f::UnitY()));
  Cloud3 seen, sensors;
  for (const Eigen::Vector3f& p : room) seen.push_back(lean * p);
  for (const Eigen::Vector3f& p : RoomSensors()) sensors.push_back(lean * p);
  const auto labels = Classify(seen, sensors, kUp, Forest::Own());
  ASSERT_TRUE(labels);
  ASSERT_EQ(labels->size(), room.size());
  const size_t above = floor.size(), around = floor.size() + ceiling.size();
  EXPECT_GT(ShareOf(*labels, 0, above, PointClass::kGround), 0.95);
  EXPECT_GT(ShareOf(*labels, above, around, PointClass::kCeiling), 0.9);
  EXPECT_GT(ShareOf(*labels, around, room.size(), PointClass::kWall), 0.9);
}

TEST(ClassifyTest, EndsWhenTold) {
  const auto at_ten = [](size_t i) { return i == 10; };
  EXPECT_FALSE(Classify(RoomFloor(), RoomSensors(), kUp, Forest::Own(), at_ten));
}

TEST(ClassifyTest, TakesAnyCloud) {
  EXPECT_TRUE(Classify(Cloud3{}, Cloud3{}, kUp, Forest::Own())->empty());
  Cloud3 odd(50, {1, 2, 3});
  odd.push_back({1e5F, -1e5F, 1e5F});
  odd.push_back({-1e5F, 1e5F, -1e5F});
  const auto labels = Classify(odd, Cloud3{{1e5F, 1e5F, 0}}, kUp, Forest::Own());
  ASSERT_EQ(labels->size(), odd.size());
  for (const PointLabel& label : *labels) {
    EXPECT_TRUE(label.probability >= 0 && label.probability <= 1) << label.probability;
    EXPECT_NE(label.likeliest, PointClass::kUnknown);
  }
}

TEST(ClassifyTest, FeaturesAreFinite) {
  Cloud3 cloud = Joined({RoomFloor(), RoomWalls()});
  cloud.push_back({1000, 0, 300});
  Surroundings surroundings(cloud, Cloud3{}, kUp);
  for (size_t i = 0; i < surroundings.size(); ++i) {
    for (const float value : surroundings.Of(i)) ASSERT_TRUE(std::isfinite(value)) << i;
  }
}

}  // namespace
}  // namespace isthmus::classes
