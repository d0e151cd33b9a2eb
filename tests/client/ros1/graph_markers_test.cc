#include "client/ros1/graph_markers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace isthmus::ros1 {
namespace {

PlacedSession Placed(const char* session, uint32_t component, double x) {
  return {{SessionId(session), component, {}, Pose(Eigen::Vector3d(x, 0, 0))}, {}};
}

MatchEdge EdgeOf(const char* a, const char* b, MatchState state, double confidence) {
  MatchEdge edge;
  edge.match.a = SessionId(a);
  edge.match.b = SessionId(b);
  edge.match.T_a_b = Pose(Eigen::Vector3d(0, 5, 0));
  edge.match.state = state;
  edge.match.matcher = GuessSource::kBirdsEye;
  edge.match.reason = state == MatchState::kAccepted ? MatchReason::kOk : MatchReason::kTooSmall;
  edge.match.confidence = confidence;
  return edge;
}

TEST(Ros1GraphMarkers, ShowSessionsAcceptedAndOpenMatches) {
  MatchGraph graph;
  graph.placements = {Placed("a-1", 0, 0), Placed("b-1", 0, 10), Placed("c-1", 1, 0),
                      Placed("d-1", 2, 0)};
  graph.matches = {EdgeOf("a-1", "b-1", MatchState::kAccepted, 0.97),
                   EdgeOf("b-1", "c-1", MatchState::kNotYet, 0.4),
                   EdgeOf("a-1", "d-1", MatchState::kRejected, 0)};
  const auto array = MakeMarkers(graph, {}, {.frame = "map", .stamp = {}});
  EXPECT_EQ(array.markers.front().action, visualization_msgs::Marker::DELETEALL);
  std::map<std::string, std::vector<visualization_msgs::Marker>> by_name;
  for (const auto& marker : array.markers) by_name[marker.ns].push_back(marker);
  ASSERT_EQ(by_name["sessions"].size(), 3U);  // Nobody knows a place for d-1.
  EXPECT_EQ(by_name["sessions"][2].pose.position.x, 10);
  EXPECT_EQ(by_name["sessions"][2].pose.position.y, 5);  // By the open match.
  EXPECT_LT(by_name["sessions"][2].color.a, 1);
  ASSERT_EQ(by_name["accepted"].size(), 1U);
  EXPECT_EQ(by_name["accepted"][0].points.size(), 2U);
  ASSERT_EQ(by_name["undecided"].size(), 1U);
  ASSERT_EQ(by_name["confidence"].size(), 2U);
  EXPECT_EQ(by_name["confidence"][0].text, "0.97");
  EXPECT_EQ(by_name["confidence"][1].text, "0.40 TOO_SMALL");
}

}  // namespace
}  // namespace isthmus::ros1
