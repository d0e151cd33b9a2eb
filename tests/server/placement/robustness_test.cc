// Edges that are wrong, contradict each other, or are none.
#include <gtest/gtest.h>

#include <limits>

#include "server/placement/graph_builder.h"
#include "server/placement/initial_poses.h"
#include "server/placement/solve_component.h"
#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

TEST(Robustness, DiscardsFalseLoops) {
  for (const uint64_t seed : {1, 2, 3, 4}) {
    World world(seed);
    world.AddRobot("a-1", 200, 50, 40);
    for (int k = 50; k < 200; k += 3) world.AddLoop("a-1", k - 50, k);
    const size_t right = world.input.loops.size();
    const double without = Rmse(world, Placer().Place(world.input, {}).placements, "a-1");
    std::mt19937 random(static_cast<uint32_t>(seed));
    while (world.input.loops.size() * 7 < right * 10) {
      const int a = static_cast<int>(random() % 180), b = static_cast<int>(random() % 180);
      if (std::abs(a - b) > 10) world.AddFalseLoop("a-1", std::min(a, b), std::max(a, b));
    }
    const Outcome outcome = Placer().Place(world.input, {});
    EXPECT_LT(Rmse(world, outcome.placements, "a-1"), 1.2 * without) << seed;
    for (const LoopClosure& loop : world.input.loops) {
      if (loop.id <= right) continue;
      EXPECT_FALSE(outcome.edge_status.loops.at(loop.id)[0]) << loop.id;
    }
  }
}

// They come one by one, with the map growing, optimised in parts and as a whole.
TEST(Robustness, DiscardsFalseLoopsAsTheyCome) {
  for (const size_t whole_up_to : {0, 500}) {
    World world(7);
    const std::vector<Node> nodes = world.AddRobot("a-1", 150, 50, 40).nodes;
    world.Find("a-1").nodes.clear();
    PlacerOptions options;
    options.whole_up_to = whole_up_to;
    Placer placer(options);
    Placements placements;
    for (int k = 0; k < 150; ++k) {
      world.Find("a-1").nodes.push_back(nodes[static_cast<size_t>(k)]);
      if (k >= 50 && k % 3 != 0) world.AddLoop("a-1", k - 50, k);
      if (k >= 50 && k % 3 == 0) world.AddFalseLoop("a-1", (k * 7) % 40, k);
      placements = placer.Place(world.input, placements).placements;
    }
    std::erase_if(world.input.loops,
                  [](const LoopClosure& loop) { return loop.submap_b % 3 == 0; });
    const Placements without = Placer().Place(world.input, {}).placements;
    EXPECT_LT(Rmse(world, placements, "a-1"), 1.2 * Rmse(world, without, "a-1") + 0.03);
  }
}

TEST(Robustness, DoesNotDoubtWhatAPersonSays) {
  World world(2);
  world.AddRobot("a-1", 60, 50, 40);
  world.AddRobot("b-1", 60, 50, 40, 10);
  world.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}, {40, 30}});
  world.AddRobot("c-1", 60, 50, 40, 20);
  world.AddMatch("b-1", "c-1", {{20, 10}, {30, 20}});
  // The match says, wrongly, that a and c began in one place.
  world.ForceMatch("a-1", "c-1", Pose());
  const Outcome outcome = Placer().Place(world.input, {});
  EXPECT_EQ(outcome.trouble, "");
  const Pose a = PoseOf(outcome.placements, "a-1", 0), c = PoseOf(outcome.placements, "c-1", 0);
  EXPECT_LT((a.translation() - c.translation()).norm(), 0.2);
}

// Nothing is left that would hold b: it lies where the tree has it, as it was shaped.
TEST(Robustness, ReturnsToTheTreeWhatLostItsMatch) {
  World world(3);
  world.AddRobot("a-1", 30, 50, 40);
  world.AddRobot("b-1", 30, 50, 40, 10);
  world.AddMatch("a-1", "b-1", {{20, 10}, {25, 15}});
  SessionNumbers numbers;
  NearestPairs nearest;
  GraphSet set = BuildGraphs(world.input, {}, {}, &numbers, &nearest);
  ASSERT_EQ(set.graphs.size(), 1u);
  Graph& graph = set.graphs[0];
  BeginPosesAnew(world.input, {}, true, &graph);
  const std::vector<Pose> tree = graph.problem.poses;
  const Pose T = Pose::FromXyzRpy(5, 6, 7, 0.1, 0.2, 0.3);
  for (size_t i = 30; i < 60; ++i) graph.problem.poses[i] = T * tree[i];
  graph.problem.edges[58].weight = 0;
  ReturnDiscardedToTree(world.input, &graph);  // The other edge still holds it.
  EXPECT_LT(Log(graph.problem.poses[40].Inverse() * T * tree[40]).norm(), 1e-9);
  graph.problem.edges[59].weight = 0;
  ReturnDiscardedToTree(world.input, &graph);
  for (size_t i = 0; i < 60; ++i) {
    EXPECT_LT(Log(graph.problem.poses[i].Inverse() * tree[i]).norm(), 1e-9);
  }
}

// Two edges that cannot both hold: whichever goes, it stays so.
TEST(Robustness, DecidesOnceBetweenTwo) {
  World world(3);
  world.AddRobot("a-1", 60, 50, 40);
  world.AddRobot("b-1", 60, 50, 40, 10);
  world.AddMatch("a-1", "b-1", {{20, 10}, {22, 12}});
  world.input.matches[0].edges[1].T_a_b = Pose(Eigen::Vector3d(0, 80, 0));
  Placer placer;
  const Outcome outcome = placer.Place(world.input, {});
  const std::vector<bool>& kept = outcome.edge_status.matches.begin()->second;
  EXPECT_FALSE(kept[0] && kept[1]);
  const Outcome again = placer.Place(world.input, outcome.placements);
  EXPECT_EQ(again.edge_status.matches.begin()->second, kept);
  EXPECT_TRUE(FindMoves(outcome.placements, again.placements).empty());
}

TEST(Robustness, PassesOverWhatIsNotThere) {
  World world(4);
  world.AddRobot("a-1", 30, 50, 40);
  world.AddRobot("b-1", 30, 50, 40, 10);
  const Placements before = Placer().Place(world.input, {}).placements;
  world.AddLoop("a-1", 2, 20);
  LoopClosure& loop = world.input.loops[0];
  loop.edges = {loop.edges[0], loop.edges[0], loop.edges[0], loop.edges[0]};
  loop.edges[0].submap_a = 77;
  loop.edges[1].submap_a = loop.edges[1].submap_b;
  loop.edges[2].T_a_b = Pose(Eigen::Vector3d(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  loop.edges[3].information(2, 2) = -1e5;
  world.input.loops.push_back(loop);
  world.input.loops[1].id = 2;
  world.input.loops[1].session = SessionId("nobody-1");
  Match match;
  match.a = SessionId("a-1");
  match.b = SessionId("nobody-1");
  match.state = MatchState::kAccepted;
  world.input.matches.push_back(match);
  match.b = SessionId("b-1");
  match.state = MatchState::kRejected;
  match.edges = {world.Measure("a-1", 12, "b-1", 2)};
  world.input.matches.push_back(match);
  Anchor anchor;
  anchor.submap = {SessionId("nobody-1"), 3};
  anchor.sigma_xy_m = 1;
  world.input.anchors.push_back(anchor);
  const Outcome outcome = Placer().Place(world.input, before);
  EXPECT_EQ(outcome.trouble, "");
  EXPECT_EQ(outcome.edges, 58u);
  EXPECT_EQ(LargestMove(before, outcome.placements), 0);
}

TEST(Robustness, TellsEdgesOfOnePairApart) {
  World world(5);
  world.AddRobot("a-1", 60, 50, 40);
  world.AddLoop("a-1", 2, 52);
  LoopClosure& loop = world.input.loops[0];
  loop.edges.push_back(loop.edges[0]);
  loop.edges[0].T_a_b = Pose(Eigen::Vector3d(30, 0, 0));
  Placer placer;
  const Outcome outcome = placer.Place(world.input, {});
  EXPECT_EQ(outcome.edge_status.loops.at(loop.id), std::vector<bool>({false, true}));
  const Outcome again = placer.Place(world.input, outcome.placements);
  EXPECT_FALSE(again.whole);
  EXPECT_EQ(again.edge_status.loops.at(loop.id), std::vector<bool>({false, true}));
}

}  // namespace
}  // namespace isthmus::placement
