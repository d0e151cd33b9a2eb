// Submaps leave the map because newer ones show the same place.
#include <gtest/gtest.h>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

TEST(Retire, LeavesTheRestWhereItIs) {
  World world(1);
  world.AddRobot("a-1", 150, 50, 40);
  for (int k = 50; k < 150; k += 5) world.AddLoop("a-1", k - 50, k);
  Placer placer;
  const Placements before = placer.Place(world.input, {}).placements;
  world.Retire("a-1", 20, 60);
  const Outcome retired = placer.Place(world.input, before);
  EXPECT_EQ(retired.nodes, 109u);
  for (const SubmapMove& move : FindMoves(before, retired.placements)) {
    EXPECT_FALSE(move.after.has_value()) << move.submap.index;
  }
  // The way there is still known: the submaps behind the gap hang on those before it.
  world.AddRobot("b-1", 3, 50, 40);
  const Outcome later = placer.Place(world.input, retired.placements);
  EXPECT_EQ(LargestMove(retired.placements, later.placements), 0);
}

TEST(Retire, KeepsTheMapFrameWithoutTheFirstSubmap) {
  World world(2);
  world.AddRobot("a-1", 150, 50, 40);
  for (int k = 50; k < 120; k += 5) world.AddLoop("a-1", k - 50, k);
  Placer placer;
  const Placements before = placer.Place(world.input, {}).placements;
  world.Retire("a-1", 0, 30);
  const Placements retired = placer.Place(world.input, before).placements;
  world.AddLoop("a-1", 80, 130);
  world.AddLoop("a-1", 90, 140);
  const Outcome closed = placer.Place(world.input, retired);
  EXPECT_TRUE(closed.whole);
  EXPECT_EQ(PoseOf(before, "a-1", 31).Matrix(), PoseOf(closed.placements, "a-1", 31).Matrix());
  // A server that was started anew knows only what readers see.
  const Placements restarted = Placer().Place(world.input, closed.placements).placements;
  EXPECT_LT(LargestMove(closed.placements, restarted), 1e-3);
}

TEST(Retire, HangsOnWhenTheReferenceHasLeft) {
  World world(3);
  world.AddRobot("a-1", 50, 50, 40);
  world.AddRobot("b-1", 50, 50, 40, 10);
  world.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}, {40, 30}});
  Placer placer;
  const Placements before = placer.Place(world.input, {}).placements;
  world.Retire("a-1", 0, 49);
  const Placements after = placer.Place(world.input, before).placements;
  ASSERT_EQ(after.size(), 1u);
  EXPECT_EQ(after[0].reference, SessionId("a-1"));
  EXPECT_EQ(LargestMove(before, after), 0);
}

// Submaps that hang on the rest by odometry alone, which has strayed for laps, stay where they
// were.
TEST(Retire, DriftOfWhatHasLeftComesNotBack) {
  World world(5);
  world.AddRobot("a-1", 150, 50, 40, 0, {.yaw_bias_rad = 0.01});
  for (int k = 50; k < 150; k += 2) world.AddLoop("a-1", k - 50, k);
  Placer placer;
  Placements placements = placer.Place(world.input, {}).placements;
  const Session& robot = world.Find("a-1");
  const Pose kept = PoseOf(placements, "a-1", 3);
  const double strayed =
      (robot.nodes[3].T_odom_submap.translation() - (robot.nodes[103].T_odom_submap.translation()))
          .norm();
  ASSERT_GT(strayed, 5) << "they are in one place";
  // One submap of the first two laps stays, and no loop closure of it.
  world.Retire("a-1", 0, 2);
  world.Retire("a-1", 4, 99);
  placements = placer.Place(world.input, placements).placements;
  EXPECT_LT((PoseOf(placements, "a-1", 3).translation() - kept.translation()).norm(), 1e-3);
  for (int k = 140; k < 150; ++k) world.AddLoop("a-1", k - 40, k);
  placements = placer.Place(world.input, placements).placements;
  placements = Placer().Place(world.input, placements).placements;
  const Pose T_3_103 = PoseOf(placements, "a-1", 3).Inverse() * PoseOf(placements, "a-1", 103);
  EXPECT_LT(T_3_103.translation().norm(), 0.5);
}

// A match whose submaps have all left still holds its sessions together, loosely.
TEST(Retire, FallsBackOnTheMatchItself) {
  World world(4);
  world.AddRobot("a-1", 50, 50, 40);
  world.AddRobot("b-1", 50, 50, 40, 10);
  world.AddMatch("a-1", "b-1", {{20, 10}, {21, 11}});
  Placer placer;
  const Placements before = placer.Place(world.input, {}).placements;
  const size_t edges = placer.Place(world.input, before).edges;
  world.Retire("a-1", 20, 21);
  const Outcome retired = placer.Place(world.input, before);
  EXPECT_EQ(retired.edges, edges - 2 - 2 + 1);  // One way over the gap, one for the match.
  EXPECT_LT(LargestMove(before, retired.placements), 0.3);
  EXPECT_EQ(retired.edge_status.matches.at({SessionId("a-1"), SessionId("b-1")}),
            std::vector<bool>({true, true}));
}

// Lap after lap only the newest is kept. The map neither opens nor wanders off.
TEST(Retire, LapsForEver) {
  constexpr int kLap = 25, kLaps = 40;
  World world(5);
  const std::vector<Node> nodes = world.AddRobot("a-1", kLap * kLaps, kLap, 20).nodes;
  world.Find("a-1").nodes.clear();
  Placer placer;
  Placements placements;
  for (int k = 0; k < kLap * kLaps; ++k) {
    world.Find("a-1").nodes.push_back(nodes[static_cast<size_t>(k)]);
    placements = placer.Place(world.input, placements).placements;
    if (k < kLap) continue;
    world.AddLoop("a-1", k - kLap, k);
    placements = placer.Place(world.input, placements).placements;
    world.Retire("a-1", static_cast<uint32_t>(k - kLap), static_cast<uint32_t>(k - kLap));
    world.input.loops.clear();
    const Outcome retired = placer.Place(world.input, placements);
    EXPECT_LE(retired.nodes, static_cast<size_t>(kLap));
    placements = retired.placements;
  }
  EXPECT_LT(Rmse(world, placements, "a-1"), 0.5);
  const Pose odom = world.Truth("a-1", 0);  // The robot's first pose.
  double farthest = 0;
  for (const SubmapPose& submap : placements[0].submaps) {
    const Pose truth = odom.Inverse() * world.Truth("a-1", submap.index);
    farthest = std::max(farthest, (truth.translation() - submap.T_map_submap.translation()).norm());
  }
  EXPECT_LT(farthest, 1.0);
  const Pose open = odom.Inverse() * world.Truth("a-1", kLap * kLaps - 1);
  EXPECT_GT((nodes.back().T_odom_submap.translation() - open.translation()).norm(), 5.0);
}

}  // namespace
}  // namespace isthmus::placement
