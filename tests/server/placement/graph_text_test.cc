#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "server/pose_graph/g2o.h"
#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

TEST(WriteG2o, IsReadBack) {
  World world(1);
  world.AddRobot("a-1", 60, 50, 40);
  world.Retire("a-1", 5, 5);
  world.AddRobot("b-1", 60, 50, 40, 10);
  world.AddRobot("c-1", 10, 50, 40, 10);
  world.AddLoop("a-1", 4, 54);
  world.AddLoop("a-1", 0, 50);
  world.AddFalseLoop("a-1", 10, 33);
  world.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}});
  Placer placer;
  const Outcome outcome = placer.Place(world.input, {});
  const auto text = placer.WriteG2o(0);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_THAT(*text, testing::StartsWith("# VERTEX 0 a-1/0\n"));
  EXPECT_THAT(*text, testing::HasSubstr("# VERTEX 5 a-1/6\n"));
  std::istringstream stream(*text);
  const auto graph = pose_graph::ReadG2o(stream);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(graph->problem.poses.size(), 119u);
  EXPECT_EQ(graph->problem.edges.size(), 117u + 2 + 2);
  EXPECT_EQ(graph->problem.fixed, std::vector<int>{0});
  EXPECT_LT(Log(graph->problem.poses[5].Inverse() * PoseOf(outcome.placements, "a-1", 6)).norm(),
            1e-9);
  EXPECT_TRUE(placer.WriteG2o(1).ok());
}

TEST(WriteG2o, KnowsWhichComponentsThereAre) {
  Placer placer;
  EXPECT_EQ(placer.WriteG2o(0).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace isthmus::placement
