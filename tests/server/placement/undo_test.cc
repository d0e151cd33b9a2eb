// Mistakes that are taken back leave nothing behind.
#include <gtest/gtest.h>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

// Two robots with loops of their own, right and false ones, and for even seeds a match.
World MakeWorld(uint64_t seed) {
  World world(seed);
  world.AddRobot("a-1", 100, 50, 40);
  world.AddRobot("b-1", 100, 50, 40, 25);
  for (int k = 50; k < 100; k += 7) {
    world.AddLoop("a-1", k - 50, k);
    world.AddLoop("b-1", k - 50, k);
  }
  world.AddFalseLoop("a-1", 10, 42);
  world.AddFalseLoop("b-1", 3, 88);
  if (seed % 2 == 0) world.AddMatch("a-1", "b-1", {{25, 0}, {30, 5}, {35, 10}});
  return world;
}

// Each test runs with and without the memory of earlier placements.
class Undo : public testing::TestWithParam<std::tuple<uint64_t, bool>> {
 protected:
  Undo() : world_(MakeWorld(std::get<0>(GetParam()))) {}

  void Begin(const PlacerOptions& options = {}) {
    options_ = options;
    placer_ = Placer(options);
    Place();
    before_ = placements_;
  }

  void Place() { placements_ = placer_.Place(world_.input, placements_).placements; }

  // Other matches come and go, so that what was before them is forgotten.
  void Forget() {
    if (std::get<1>(GetParam())) return;
    world_.AddRobot("x-1", 3, 50, 40);
    world_.AddRobot("y-1", 3, 50, 40);
    for (int i = 0; i < 10; ++i) {
      world_.ForceMatch("x-1", "y-1", Pose(Eigen::Vector3d(i, 0, 0)));
      Place();
      world_.RemoveMatch("x-1", "y-1");
      Place();
    }
  }

  World world_;
  PlacerOptions options_;
  Placer placer_;
  Placements before_, placements_;
};

TEST_P(Undo, OfAForcedMatch) {
  Begin();
  const bool joined = before_[0].reference == before_[1].reference;
  if (joined) world_.RemoveMatch("a-1", "b-1");
  world_.ForceMatch("a-1", "b-1", Pose::FromXyzRpy(3, 4, 0, 0, 0, 1));
  Place();
  EXPECT_GT(LargestMove(before_, placements_), 1.0);
  Forget();
  world_ = MakeWorld(std::get<0>(GetParam()));
  Place();
  EXPECT_LT(LargestMove(before_, placements_), 1e-3);
}

// It bends one component, by way of a third session.
TEST_P(Undo, OfForcedMatchesRoundACycle) {
  Begin();
  world_.AddRobot("c-1", 30, 50, 40);
  world_.ForceMatch("a-1", "c-1", Pose(Eigen::Vector3d(3, 4, 0)));
  world_.ForceMatch("b-1", "c-1", Pose(Eigen::Vector3d(-9, 2, 0)));
  Place();
  EXPECT_GT(LargestMove(before_, placements_), 1.0);
  Forget();
  world_.RemoveMatch("b-1", "c-1");
  Place();
  world_.RemoveMatch("a-1", "c-1");
  Place();
  EXPECT_LT(LargestMove(before_, placements_), 1e-3);
}

TEST_P(Undo, OfARejectedLoop) {
  Begin();
  world_.AddLoop("a-1", 3, 60);
  LoopClosure& loop = world_.input.loops.back();
  // Wrong by so little that it is believed.
  loop.edges[0].T_a_b = loop.edges[0].T_a_b * Pose(Eigen::Vector3d(0.05, 0, 0));
  loop.edges[0].information *= 0.1;
  Place();
  EXPECT_TRUE(placer_.Place(world_.input, placements_).edge_status.loops.at(loop.id)[0]);
  EXPECT_GT(LargestMove(before_, placements_), 2e-3);
  Forget();
  loop.rejected = true;
  Place();
  EXPECT_LT(LargestMove(before_, placements_), 1e-3);
}

TEST_P(Undo, OfADeletedSession) {
  Begin();
  const Input before = world_.input;
  world_.AddRobot("c-1", 30, 50, 40);
  world_.ForceMatch("a-1", "c-1", Pose(Eigen::Vector3d(3, 4, 0)));
  world_.ForceMatch("b-1", "c-1", Pose(Eigen::Vector3d(-9, 2, 0)));
  Place();
  Forget();
  world_.input = before;
  Place();
  EXPECT_LT(LargestMove(before_, placements_), 1e-3);
  EXPECT_EQ(placements_.size(), before_.size());
}

INSTANTIATE_TEST_SUITE_P(Seeds, Undo,
                         testing::Combine(testing::Values(1, 2, 3, 4, 5), testing::Bool()));

// Optimising only around a change makes poses depend on the order of changes; a change that is
// taken back soon leaves them as they were all the same.
TEST(UndoInParts, OfAForcedMatch) {
  for (const uint64_t seed : {1, 2, 3}) {
    World world(seed);
    world.AddRobot("a-1", 150, 50, 40);
    PlacerOptions options;
    options.whole_up_to = 0;
    Placer placer(options);
    Placements placements = placer.Place(world.input, {}).placements;
    for (int k = 50; k < 150; k += 3) {
      world.AddLoop("a-1", k - 50, k);
      placements = placer.Place(world.input, placements).placements;
    }
    const Placements before = placements;
    world.AddRobot("c-1", 30, 50, 40);
    world.AddMatch("a-1", "c-1", {{3, 3}, {40, 25}});
    world.input.matches.back().reason = MatchReason::kByHand;
    world.input.matches.back().edges[1].T_a_b = Pose(Eigen::Vector3d(4, 0, 0));
    placements = placer.Place(world.input, placements).placements;
    EXPECT_GT(LargestMove(before, placements), 0.3);
    // A loop that is found meanwhile is not lost.
    world.AddLoop("a-1", 7, 57);
    placements = placer.Place(world.input, placements).placements;
    world.RemoveMatch("a-1", "c-1");
    const Outcome undone = placer.Place(world.input, placements);
    EXPECT_LT(LargestMove(before, undone.placements), 0.05);
    EXPECT_TRUE(undone.edge_status.loops.at(world.input.loops.back().id)[0]);
    world.input.loops.pop_back();
    const Placements last = placer.Place(world.input, undone.placements).placements;
    EXPECT_LT(LargestMove(before, last), 1e-3);
  }
}

}  // namespace
}  // namespace isthmus::placement
