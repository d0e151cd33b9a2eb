// Floors told by where sensors were.
#include "core/floors/floors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::floors {
namespace {

using Stations = std::vector<Eigen::Vector3d>;

// `count` stations at half a metre, from that height on, each so much higher than the last.
void Drive(int count, double z, double rise, Stations* stations) {
  for (int i = 0; i < count; ++i) stations->emplace_back(0.5 * i, 0, z + rise * i);
}

TEST(Floors, StoreysArePartedAndStairsBelongToNone) {
  Stations stations;
  Drive(100, 0.5, 0, &stations);
  Drive(12, 0.5, 0.25, &stations);  // Stairs, up to the second storey.
  Drive(80, 3.5, 0, &stations);
  const std::vector<Floor> floors = FloorsOf(stations);
  ASSERT_EQ(floors.size(), 2u);
  EXPECT_GE(floors[0].stations.size(), 100u);
  EXPECT_GE(floors[1].stations.size(), 80u);
  EXPECT_LT(floors[0].highest_m, 1.1);
  EXPECT_GT(floors[1].lowest_m, 2.9);
}

TEST(Floors, ASlopeIsOneFloor) {
  Stations stations;
  Drive(400, -2, 0.02, &stations);
  const std::vector<Floor> floors = FloorsOf(stations);
  ASSERT_EQ(floors.size(), 1u);
  EXPECT_EQ(floors[0].stations.size(), 400u);
  EXPECT_NEAR(floors[0].highest_m - floors[0].lowest_m, 399 * 0.02, 1e-9);
}

TEST(Floors, AFewStationsAreOneFloor) {
  EXPECT_TRUE(FloorsOf({}).empty());
  Stations stations;
  Drive(3, 1, 0, &stations);
  ASSERT_EQ(FloorsOf(stations).size(), 1u);
  EXPECT_EQ(FloorsOf(stations)[0].stations.size(), 3u);
}

}  // namespace
}  // namespace isthmus::floors
