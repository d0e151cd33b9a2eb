#include "lab/simulation/worlds/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lab/simulation/sensors/ray_caster.h"

namespace isthmus::simulation {
namespace {

using ::testing::HasSubstr;

TEST(World, UnknownNameListsTheKnownOnes) {
  const auto world = MakeWorld("moon", 1);
  ASSERT_EQ(world.status().code(), absl::StatusCode::kInvalidArgument);
  for (const std::string& name : WorldNames()) {
    EXPECT_THAT(std::string(world.status().message()), HasSubstr(name));
  }
}

class EveryWorld : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryWorld, IsWellFormed) {
  const World world = *MakeWorld(GetParam(), 3);
  EXPECT_EQ(world.name, GetParam());
  ASSERT_GT(world.mesh.triangles.size(), 100u);
  ASSERT_EQ(world.mesh.triangles.size(), world.mesh.materials.size());
  for (const auto& vertex : world.mesh.vertices) ASSERT_TRUE(vertex.allFinite());
  for (const auto& triangle : world.mesh.triangles) {
    for (const uint32_t corner : triangle) ASSERT_LT(corner, world.mesh.vertices.size());
  }
}

TEST_P(EveryWorld, FollowsFromItsSeed) {
  const World first = *MakeWorld(GetParam(), 3), again = *MakeWorld(GetParam(), 3);
  const World other = *MakeWorld(GetParam(), 4);
  EXPECT_EQ(first.mesh.vertices, again.mesh.vertices);
  EXPECT_EQ(first.roads.places, again.roads.places);
  EXPECT_NE(first.mesh.vertices, other.mesh.vertices);
}

INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld, ::testing::ValuesIn(WorldNames()),
                         [](const auto& test) { return test.param; });

// A fan of rays from a point, a little above and below the horizon.
std::vector<Hit> LookAround(const World& world, const Eigen::Vector3f& from) {
  std::vector<Ray> rays;
  for (int i = 0; i < 720; ++i) {
    const float azimuth = static_cast<float>(i) * 0.05f, z = 0.1f * static_cast<float>(i % 5 - 2);
    rays.push_back({from, Eigen::Vector3f(std::cos(azimuth), std::sin(azimuth), z).normalized()});
  }
  std::vector<Hit> hits(rays.size());
  RayCaster(world.mesh).Cast(rays, 100, hits);
  return hits;
}

TEST(Twins, RoomsLookTheSameFromCorrespondingPoints) {
  const World world = *MakeWorld("twins", 5);
  const auto left = LookAround(world, {3, 2, 0.8f}), right = LookAround(world, {37, 2, 0.8f});
  for (size_t i = 0; i < left.size(); ++i) {
    ASSERT_GT(left[i].range_m, 0);  // Closed: nothing is seen of the other.
    ASSERT_LT(left[i].range_m, 16);
    EXPECT_NEAR(left[i].range_m, right[i].range_m, 1e-3) << i;
  }
}

TEST(Twins, LargeOnesAreHallsThatLookTheSame) {
  const World world = *MakeWorld("twins_large", 5);
  const auto left = LookAround(world, {3, 2, 0.8f}), right = LookAround(world, {63, 2, 0.8f});
  for (size_t i = 0; i < left.size(); ++i) {
    ASSERT_GT(left[i].range_m, 0);
    EXPECT_NEAR(left[i].range_m, right[i].range_m, 1e-3) << i;
  }
  const Eigen::Vector2d middle = world.roads.Center(1) - world.roads.Center(0);
  EXPECT_NEAR(middle.x(), 60, 1e-9);
  EXPECT_NEAR(middle.y(), 0, 1e-9);
}

TEST(Twins, WingsDiffer) {
  const World world = *MakeWorld("twins_wings", 5);
  ASSERT_EQ(world.roads.places.size(), 4u);
  const auto differing = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    const auto left = LookAround(world, a), right = LookAround(world, b);
    int different = 0;
    for (size_t i = 0; i < left.size(); ++i) {
      EXPECT_GT(left[i].range_m, 0);
      different += std::abs(left[i].range_m - right[i].range_m) > 1e-3f ? 1 : 0;
    }
    return different;
  };
  EXPECT_LT(differing({3, 2, 0.8f}, {63, 2, 0.8f}), 20);  // In the halls.
  // Past the doors: only the walls to the west and south are alike.
  EXPECT_GT(differing({7, 24, 0.8f}, {67, 24, 0.8f}), 300);
}

TEST(Twins, JoinedOnesDifferByTheHall) {
  const World world = *MakeWorld("twins_joined", 5);
  const auto left = LookAround(world, {7, 8, 0.8f}), right = LookAround(world, {41, 8, 0.8f});
  int same = 0, different = 0;
  for (size_t i = 0; i < left.size(); ++i) {
    ++(std::abs(left[i].range_m - right[i].range_m) < 1e-3f ? same : different);
  }
  EXPECT_GT(same, 400);
  EXPECT_GT(different, 20);
}

TEST(Corridor, IsBare) {
  const World world = *MakeWorld("corridor", 2);
  // Side walls at the same distance wherever one stands between the lobbies.
  const auto here = LookAround(world, {30, 4.5f, 0.8f}),
             there = LookAround(world, {60, 4.5f, 0.8f});
  for (size_t i = 0; i < here.size(); ++i) {
    if (here[i].range_m > 15) continue;
    EXPECT_NEAR(here[i].range_m, there[i].range_m, 1e-3) << i;
  }
}

}  // namespace
}  // namespace isthmus::simulation
