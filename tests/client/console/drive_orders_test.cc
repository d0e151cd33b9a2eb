#include "client/console/drive_orders.h"

#include <gtest/gtest.h>

#include "client/console/match_text.h"

namespace isthmus::cli {
namespace {

// Robot bob is asked to drive 2 m ahead and 1 m to the left.
MatchGraph Asking() {
  MatchGraph graph;
  MatchEdge& edge = graph.matches.emplace_back();
  edge.match.a = SessionId("alice-1");
  edge.match.b = SessionId("bob-1");
  edge.match.matcher = GuessSource::kBirdsEye;
  edge.match.computed_ns = 7;
  edge.robot_a = RobotId("alice");
  edge.robot_b = RobotId("bob");
  RobotDrive& drive = edge.asked_drives.emplace_back();
  drive.robot = RobotId("bob");
  drive.session = SessionId("bob-1");
  drive.way = {{1, 2, 0.5}, {3, 2, 0.5}, {3, 3, 0.5}};
  drive.leaves_own = 1;
  drive.length_m = 3;
  drive.confidence = 0.97;
  graph.placements = {{{SessionId("bob-1"), 1, SessionId("carol-4"), {}}, RobotId("bob")}};
  return graph;
}

TEST(DriveOrdersTest, AMatchSaysInWordsWhatWouldTell) {
  EXPECT_NE(MatchText(Asking().matches[0])
                .find("to tell: bob drives 3 m, leaves its own way at 3.0 2.0, goes where alice "
                      "was, to 3.0 3.0; then 97 % probable if it is this place"),
            std::string::npos)
      << MatchText(Asking().matches[0]);
}

TEST(DriveOrdersTest, GoalsLookAlongTheWay) {
  const Json goals = NavigationGoals(Asking())["goals"];
  ASSERT_EQ(goals.size(), 1u);
  EXPECT_EQ(goals[0]["robot"], "bob");
  const Json& poses = goals[0]["goal"]["poses"];
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[0]["header"]["frame_id"], "map");
  EXPECT_EQ(poses[1]["pose"]["position"]["x"], 3);
  EXPECT_NEAR(poses[0]["pose"]["orientation"]["w"].get<double>(), 1, 1e-9);
  EXPECT_NEAR(poses[2]["pose"]["orientation"]["z"].get<double>(), std::sqrt(0.5), 1e-9);
}

TEST(DriveOrdersTest, OrdersAreOneReleasedChainOnTheRobotsMap) {
  const Json orders = VehicleOrders(Asking())["orders"];
  ASSERT_EQ(orders.size(), 1u);
  EXPECT_EQ(orders[0]["serialNumber"], "bob");
  ASSERT_EQ(orders[0]["nodes"].size(), 3u);
  ASSERT_EQ(orders[0]["edges"].size(), 2u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(orders[0]["nodes"][i]["sequenceId"], 2 * i);
    EXPECT_EQ(orders[0]["nodes"][i]["nodePosition"]["mapId"], "carol-4");
  }
  EXPECT_EQ(orders[0]["edges"][1]["sequenceId"], 3);
  EXPECT_EQ(orders[0]["edges"][1]["startNodeId"], orders[0]["nodes"][1]["nodeId"]);
  EXPECT_EQ(orders[0]["edges"][1]["endNodeId"], orders[0]["nodes"][2]["nodeId"]);
}

}  // namespace
}  // namespace isthmus::cli
