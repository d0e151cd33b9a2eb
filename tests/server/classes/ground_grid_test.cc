#include "server/classes/ground_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/classes/clouds.h"

namespace isthmus::classes {
namespace {

float GroundAt(const GroundGrid& grid, float x, float y) { return grid.At({x, y, 0}).ground_m; }

TEST(GroundGridTest, FollowsASlopeFromBelowTheSensor) {
  Cloud3 slope;
  AddPatch({0, -5, 0}, {40, 0, 4}, {0, 10, 0}, &slope);  // Rises by a tenth.
  const Cloud3 sensors = {{2, 0, 1.2F}, {4, 0, 1.4F}};
  const GroundGrid grid(slope, sensors);
  for (float x = 1; x < 39; x += 2) EXPECT_NEAR(GroundAt(grid, x, 1), 0.1F * x, 0.15F) << x;
}

TEST(GroundGridTest, ATableIsNoGround) {
  Cloud3 cloud = RoomFloor();
  // The floor below the table is not seen.
  std::erase_if(cloud, [](const Eigen::Vector3f& p) {
    return p.x() > 5 && p.x() < 9 && p.y() > 1 && p.y() < 3;
  });
  AddPatch({5, 1, 0.75F}, {4, 0, 0}, {0, 2, 0}, &cloud);
  const GroundGrid grid(cloud, RoomSensors());
  EXPECT_NEAR(GroundAt(grid, 7, 2), 0, 0.05F);
  EXPECT_GT(grid.At({7, 2, 0}).guessed, 0);
}

TEST(GroundGridTest, WithoutSensorsTheLowestIsGround) {
  const GroundGrid grid(Joined({RoomFloor(), RoomCeiling()}), Cloud3{});
  EXPECT_NEAR(GroundAt(grid, 6, 4), 0, 0.05F);
}

TEST(GroundGridTest, EveryCellIsReachedHoweverFarPointsLie) {
  Cloud3 far = RoomFloor();
  far.push_back({90'000, 4, 1});
  far.push_back({-4, 80'000, 1});
  const GroundGrid grid(far, RoomSensors());
  EXPECT_LE(grid.layout().size(), 600'000u);
  EXPECT_GE(grid.At({90'000, 4, 1}).steps, 0);
  EXPECT_EQ(grid.At({90'000, 4, 1}).lowest_around_m, 1);
  const GroundGrid none(Cloud3{}, Cloud3{});
  EXPECT_EQ(none.layout().size(), 1u);
}

}  // namespace
}  // namespace isthmus::classes
