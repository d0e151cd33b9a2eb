// Going on from the last solution comes to what solving everything comes to.
#include <gtest/gtest.h>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

TEST(Incremental, FiveHundredAdditionsComeToTheWhole) {
  constexpr int kSubmaps = 500, kLap = 100;
  World world(1);
  const std::vector<Node> nodes = world.AddRobot("a-1", kSubmaps, kLap, 80).nodes;
  world.Find("a-1").nodes.clear();
  PlacerOptions options;
  options.whole_up_to = 50;
  options.whole_after = 9;
  Placer placer(options);
  Placements placements;
  int partial = 0, whole = 0;
  for (int k = 0; k < kSubmaps; ++k) {
    world.Find("a-1").nodes.push_back(nodes[static_cast<size_t>(k)]);
    if (k >= kLap && k % 4 == 0) world.AddLoop("a-1", k - kLap, k);
    const Outcome outcome = placer.Place(world.input, placements);
    ASSERT_EQ(outcome.trouble, "");
    if (k >= kLap && k % 4 == 0) ++(outcome.whole ? whole : partial);
    placements = outcome.placements;
  }
  EXPECT_EQ(partial, 89);
  EXPECT_EQ(whole, 11);
  const Placements anew = Placer().Place(world.input, {}).placements;
  EXPECT_LT(LargestMove(anew, placements), 0.1);
  // Small maps are always placed as a whole.
  options.whole_up_to = 1000;
  Placer wholly(options);
  Placements last = wholly.Place(world.input, placements).placements;
  EXPECT_LT(LargestMove(anew, last), 1e-3);
}

TEST(Incremental, ANewSubmapMovesNothing) {
  World world(2);
  const std::vector<Node> nodes = world.AddRobot("a-1", 120, 50, 40).nodes;
  world.Find("a-1").nodes.resize(110);
  for (int k = 50; k < 110; k += 5) world.AddLoop("a-1", k - 50, k);
  Placer placer;
  Placements placements = placer.Place(world.input, {}).placements;
  for (size_t k = 110; k < 120; ++k) {
    world.Find("a-1").nodes.push_back(nodes[k]);
    const Outcome outcome = placer.Place(world.input, placements);
    EXPECT_FALSE(outcome.whole);
    const std::vector<SubmapMove> moves = FindMoves(placements, outcome.placements);
    ASSERT_EQ(moves.size(), 1u);
    EXPECT_EQ(moves[0].submap, (SubmapId{SessionId("a-1"), static_cast<uint32_t>(k)}));
    EXPECT_FALSE(moves[0].before.has_value());
    placements = outcome.placements;
  }
}

TEST(Incremental, ManyNewEdgesArePlacedAsAWhole) {
  World world(3);
  world.AddRobot("a-1", 150, 50, 40);
  PlacerOptions options;
  options.whole_up_to = 10;
  options.whole_above_edges = 5;
  Placer placer(options);
  Placements placements = placer.Place(world.input, {}).placements;
  world.AddLoop("a-1", 0, 50);
  Outcome outcome = placer.Place(world.input, placements);
  EXPECT_FALSE(outcome.whole);
  for (int k = 51; k < 57; ++k) world.AddLoop("a-1", k - 50, k);
  outcome = placer.Place(world.input, outcome.placements);
  EXPECT_TRUE(outcome.whole);
}

// A refined match changes some edges and loses some; the others hold on.
TEST(Incremental, FollowsAMatchThatIsRefined) {
  for (const size_t whole_up_to : {0, 500}) {
    World world(4);
    world.AddRobot("a-1", 60, 50, 40);
    world.AddRobot("b-1", 60, 50, 40, 10);
    world.AddMatch("a-1", "b-1", {{20, 10}, {25, 15}, {30, 20}, {35, 25}, {40, 30}});
    PlacerOptions options;
    options.whole_up_to = whole_up_to;
    Placer placer(options);
    Placements placements = placer.Place(world.input, {}).placements;
    std::vector<SubmapEdge>& edges = world.input.matches[0].edges;
    edges.erase(edges.begin() + 1);
    edges[1] = world.Measure("a-1", 30, "b-1", 20);
    edges.push_back(world.Measure("a-1", 45, "b-1", 35));
    const Outcome refined = placer.Place(world.input, placements);
    EXPECT_EQ(refined.edge_status.matches.begin()->second, std::vector<bool>(5, true));
    const Placements anew = Placer().Place(world.input, {}).placements;
    EXPECT_LT(LargestMove(anew, refined.placements), 0.02) << whole_up_to;
  }
}

// A server that was started anew goes on from what readers see, and in the same frames.
TEST(Incremental, GoesOnFromPublishedPoses) {
  World world(5);
  world.AddRobot("a-1", 100, 50, 40);
  world.AddRobot("b-1", 100, 50, 40, 10);
  for (int k = 50; k < 100; k += 5) world.AddLoop("a-1", k - 50, k);
  world.AddMatch("a-1", "b-1", {{60, 50}, {70, 60}, {95, 85}});
  const Placements before = Placer().Place(world.input, {}).placements;
  Placer restarted;
  const Placements after = restarted.Place(world.input, before).placements;
  EXPECT_LT(LargestMove(before, after), 1e-3);
  world.AddLoop("a-1", 3, 53);
  EXPECT_LT(LargestMove(before, restarted.Place(world.input, after).placements), 0.1);
}

}  // namespace
}  // namespace isthmus::placement
