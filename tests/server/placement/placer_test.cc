#include "server/placement/placer.h"

#include <gtest/gtest.h>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

TEST(Placer, PlacesNothingOfNothing) {
  Placer placer;
  const Outcome outcome = placer.Place({}, {});
  EXPECT_TRUE(outcome.placements.empty());
  EXPECT_EQ(outcome.trouble, "");
}

TEST(Placer, LeavesALoneSessionAsItsOdometry) {
  World world(1);
  const std::vector<Node> nodes = world.AddRobot("a-1", 50, 25, 20).nodes;
  Placer placer;
  Placements placements;
  for (size_t count = 1; count <= nodes.size(); ++count) {
    world.Find("a-1").nodes.assign(nodes.begin(),
                                   nodes.begin() + static_cast<std::ptrdiff_t>(count));
    const Outcome outcome = placer.Place(world.input, placements);
    ASSERT_EQ(outcome.trouble, "");
    EXPECT_EQ(outcome.nodes, count);
    placements = outcome.placements;
  }
  ASSERT_EQ(placements.size(), 1u);
  EXPECT_EQ(placements[0].reference, SessionId("a-1"));
  for (const Node& node : nodes) {
    const Pose gap = PoseOf(placements, "a-1", node.index).Inverse() * node.T_odom_submap;
    EXPECT_LT(Log(gap).norm(), 1e-9);
  }
  EXPECT_LT(Log(placements[0].T_map_odom).norm(), 1e-9);
}

TEST(Placer, LeavesOutSessionsWithoutSubmaps) {
  World world(1);
  world.AddRobot("a-1", 5, 25, 20);
  world.AddRobot("b-1", 0, 25, 20);
  const Outcome outcome = Placer().Place(world.input, {});
  ASSERT_EQ(outcome.placements.size(), 1u);
  EXPECT_EQ(outcome.placements[0].session, SessionId("a-1"));
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
    EXPECT_LT(Rmse(world, closed.placements, "a-1"), 0.2);
    // The robot's newest poses go where its newest submap is.
    const Pose newest =
        closed.placements[0].T_map_odom * world.Find("a-1").nodes.back().T_odom_submap;
    EXPECT_LT(Log(newest.Inverse() * PoseOf(closed.placements, "a-1", 149)).norm(), 1e-9);
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
  EXPECT_EQ(joined.edge_status.matches.at({SessionId("a-1"), SessionId("b-1")}),
            std::vector<bool>(pairs.size(), true));
  EXPECT_LT(LargestMove({apart[0]}, joined.placements), 0.2);  // The reference stays.
  EXPECT_EQ(PoseOf(apart, "a-1", 0).Matrix(), PoseOf(joined.placements, "a-1", 0).Matrix());
  for (const auto& [i, j] : pairs) {
    const Pose T =
        PoseOf(joined.placements, "a-1", i).Inverse() * PoseOf(joined.placements, "b-1", j);
    const Pose truth = world.Truth("a-1", i).Inverse() * world.Truth("b-1", j);
    EXPECT_LT((T.translation() - truth.translation()).norm(), 0.05);
  }
}

// Components that were bent before they are joined keep their shape: nothing moves against each
// other by more than the joining edges ask for.
TEST(Placer, JoinsComponentsAsTheyAreShaped) {
  World world(5);
  world.AddRobot("a-1", 100, 50, 40);
  world.AddRobot("b-1", 100, 50, 40, 10);
  for (int k = 50; k < 100; k += 5) {
    world.AddLoop("a-1", k - 50, k);
    world.AddLoop("b-1", k - 50, k);
  }
  Placer placer;
  const Placements apart = placer.Place(world.input, {}).placements;
  world.AddMatch("a-1", "b-1", {{60, 50}});
  const Placements joined = placer.Place(world.input, apart).placements;
  const auto relative = [](const Placements& placements, uint32_t k) {
    return PoseOf(placements, "b-1", 0).Inverse() * PoseOf(placements, "b-1", k);
  };
  for (uint32_t k = 1; k < 100; ++k) {
    EXPECT_LT(Log(relative(apart, k).Inverse() * relative(joined, k)).norm(), 2e-3) << k;
  }
  EXPECT_LT(LargestMove({apart[0]}, joined), 1e-3);
}

TEST(Placer, IsDeterministic) {
  Placements runs[2];
  for (Placements& placements : runs) {
    World world(6);
    world.AddRobot("a-1", 100, 50, 40);
    world.AddRobot("b-1", 60, 50, 40, 10);
    PlacerOptions options;
    options.whole_up_to = 20;
    Placer placer(options);
    placements = placer.Place(world.input, {}).placements;
    for (int k = 50; k < 100; k += 5) {
      world.AddLoop("a-1", k - 50, k);
      placements = placer.Place(world.input, placements).placements;
    }
    world.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}});
    placements = placer.Place(world.input, placements).placements;
  }
  EXPECT_TRUE(FindMoves(runs[0], runs[1]).empty());
}

TEST(Placer, PublishesNoMovesOfTheLastDigit) {
  World world(7);
  world.AddRobot("a-1", 100, 50, 40);
  for (int k = 50; k < 100; k += 5) world.AddLoop("a-1", k - 50, k);
  Placer placer;
  const Placements first = placer.Place(world.input, {}).placements;
  // The same again, by one that remembers and by one that does not.
  EXPECT_TRUE(FindMoves(first, placer.Place(world.input, first).placements).empty());
  EXPECT_TRUE(FindMoves(first, Placer().Place(world.input, first).placements).empty());
  // A submap that was placed a little off, as by another machine, stays there.
  Placements shifted = first;
  shifted[0].submaps[30].T_map_submap =
      Pose(Eigen::Vector3d(1e-4, 0, 0)) * shifted[0].submaps[30].T_map_submap;
  EXPECT_TRUE(FindMoves(shifted, Placer().Place(world.input, shifted).placements).empty());
}

// The loop is closed where the odometry says that it strayed.
TEST(Placer, TrustsWhatTheOdometrySaysOfItsDrift) {
  double bend[2] = {};
  for (const int told : {0, 1}) {
    World world(8);
    std::vector<Node>& nodes = world.AddRobot("a-1", 51, 50, 40).nodes;
    if (told == 1) nodes[10].drift_covariance = 100 * Matrix6d::Identity();
    Placer placer;
    const Placements open = placer.Place(world.input, {}).placements;
    world.AddLoop("a-1", 0, 50);
    const Placements closed = placer.Place(world.input, open).placements;
    const Pose before = PoseOf(open, "a-1", 0).Inverse() * PoseOf(open, "a-1", 9);
    const Pose after = PoseOf(closed, "a-1", 0).Inverse() * PoseOf(closed, "a-1", 9);
    bend[told] = (before.translation() - after.translation()).norm();
  }
  EXPECT_GT(bend[0], 0.1);
  EXPECT_LT(bend[1], 0.1 * bend[0]);
}

}  // namespace
}  // namespace isthmus::placement
