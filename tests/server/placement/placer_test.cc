#include "server/placement/placer.h"

#include <gtest/gtest.h>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

TEST(Placer, LeavesALoneSessionAsItsOdometry) {
  World world(1);
  const Session& session = world.AddRobot("a-1", 50, 25, 20);
  Placer placer;
  const Outcome outcome = placer.Place(world.input, {});
  ASSERT_EQ(outcome.placements.size(), 1u);
  EXPECT_EQ(outcome.placements[0].reference, SessionId("a-1"));
  EXPECT_EQ(outcome.trouble, "");
  EXPECT_EQ(outcome.placements[0].T_map_odom.Matrix(), Eigen::Matrix4d::Identity());
  for (const Node& node : session.nodes) {
    EXPECT_EQ(PoseOf(outcome.placements, "a-1", node.index).Matrix(), node.T_odom_submap.Matrix());
  }
}

TEST(Placer, ClosesLoops) {
  for (const uint64_t seed : {1, 2, 3}) {
    World world(seed);
    world.AddRobot("a-1", 150, 50, 40);
    Placer placer;
    const Placements open = placer.Place(world.input, {}).placements;
    for (int k = 50; k < 150; k += 5) world.AddLoop("a-1", k - 50, k);
    const Outcome closed = placer.Place(world.input, open);
    EXPECT_EQ(closed.trouble, "");
    EXPECT_TRUE(closed.whole);
    EXPECT_TRUE(closed.converged);
    EXPECT_GT(Rmse(world, open, "a-1"), 1.0);
    EXPECT_LT(Rmse(world, closed.placements, "a-1"), 0.1) << Rmse(world, open, "a-1");
  }
}

TEST(Placer, JoinsTwoSessions) {
  World world(4);
  world.AddRobot("a-1", 40, 50, 40);
  world.AddRobot("b-1", 40, 50, 40, 25);
  Placer placer;
  const Placements apart = placer.Place(world.input, {}).placements;
  EXPECT_NE(apart[0].reference, apart[1].reference);
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t k = 25; k < 40; k += 3) pairs.emplace_back(k, k - 25);
  world.AddMatch("a-1", "b-1", pairs);
  const Outcome joined = placer.Place(world.input, apart);
  EXPECT_EQ(joined.placements[1].reference, SessionId("a-1"));
  EXPECT_EQ(joined.judgement.matches.at({SessionId("a-1"), SessionId("b-1")}),
            std::vector<bool>(pairs.size(), true));
  for (const auto& [i, j] : pairs) {
    const Pose T =
        PoseOf(joined.placements, "a-1", i).Inverse() * PoseOf(joined.placements, "b-1", j);
    const Pose truth = world.Truth("a-1", i).Inverse() * world.Truth("b-1", j);
    EXPECT_LT((T.translation() - truth.translation()).norm(), 0.05);
  }
}

TEST(Placer, IsAsBeforeAfterAWrongMatchIsTakenBack) {
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    World world(seed);
    world.AddRobot("a-1", 100, 50, 40);
    world.AddRobot("b-1", 100, 50, 40, 25);
    for (int k = 50; k < 100; k += 7) {
      world.AddLoop("a-1", k - 50, k);
      world.AddLoop("b-1", k - 50, k);
    }
    if (seed % 2 == 0) world.AddMatch("a-1", "b-1", {{25, 0}, {30, 5}, {35, 10}});
    Placer placer;
    const Placements before = placer.Place(world.input, {}).placements;
    world.AddRobot("c-1", 30, 50, 40);
    world.ForceMatch("a-1", "c-1", Pose(Eigen::Vector3d(3, 4, 0)));
    world.ForceMatch("b-1", "c-1", Pose(Eigen::Vector3d(-9, 2, 0)));
    const Placements forced = placer.Place(world.input, before).placements;
    EXPECT_GT(LargestMove(before, forced), 1.0);
    world.RemoveMatch("b-1", "c-1");
    world.RemoveMatch("a-1", "c-1");
    const Placements after = placer.Place(world.input, forced).placements;
    EXPECT_LT(LargestMove(before, after), 1e-3) << seed;
    EXPECT_EQ(PlacementOf(before, "b-1").reference, PlacementOf(after, "b-1").reference);
  }
}

}  // namespace
}  // namespace isthmus::placement
