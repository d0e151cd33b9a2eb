#include "client/console/json.h"

#include <gtest/gtest.h>

#include "isthmus/v1/map_service.pb.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::cli {
namespace {

TEST(Json, HasTheNamesOfTheApiAndEveryFieldWithoutPresence) {
  v1::Session session;
  session.set_id("alice-1");
  session.set_tracking(v1::TRACKING_OK);
  const Json json = ToJson(session);
  EXPECT_EQ(json["id"], "alice-1");
  EXPECT_EQ(json["tracking"], "TRACKING_OK");
  EXPECT_EQ(json["state"], "STATE_UNSPECIFIED");
  EXPECT_EQ(json["travelled_m"], 0);
  EXPECT_EQ(json["input"], "");
  for (const char* absent : {"component", "t_map_odom", "scan_counts"}) {
    EXPECT_FALSE(json.contains(absent)) << absent;
  }
  session.set_component(0);
  EXPECT_EQ(ToJson(session)["component"], 0);
}

// Scripts that find text in place of a number compare it letter by letter.
TEST(Json, HasIntegersOfAllSizesAsNumbersAndHashesAsText) {
  v1::WatchMapResponse step;
  step.set_revision(42);
  step.set_run(UINT64_MAX);
  step.add_tiles()->set_points(UINT64_MAX);
  step.mutable_tiles(0)->set_version(7);
  step.add_robots()->set_stamp_ns(INT64_MIN);
  step.mutable_robots(0)->mutable_localising()->set_scans(3);
  const Json json = Json::parse(ToJson(step).dump());
  EXPECT_EQ(json["revision"], 42);
  EXPECT_EQ(json["run"], "18446744073709551615");
  EXPECT_EQ(json["tiles"][0]["points"], UINT64_MAX);
  EXPECT_EQ(json["tiles"][0]["version"], "7");
  EXPECT_EQ(json["robots"][0]["stamp_ns"], INT64_MIN);
  EXPECT_EQ(json["robots"][0]["localising"]["scans"], 3);
  v1::Revision revision;
  revision.add_loops(3);
  EXPECT_EQ(ToJson(revision)["loops"][0], 3);
}

TEST(Json, HasThePoseOfTheApi) {
  const Json json = ToJson(Pose(Eigen::Vector3d(1, 2, 3)));
  EXPECT_EQ(json["translation"], Json({{"x", 1}, {"y", 2}, {"z", 3}}));
  EXPECT_EQ(json["rotation"]["w"], 1);
}

TEST(Json, AMatchHasTheEdgesThatCameWithIt) {
  MatchEdge edge;
  edge.match.odometry_residual = 2;
  EXPECT_EQ(ToJson(edge)["odometry_residual"], 2);
  EXPECT_EQ(ToJson(edge)["overlap"], -1) << "not computed";
  EXPECT_TRUE(ToJson(edge)["edges"].empty());
  edge.match.edges.resize(1);
  edge.match.edges[0].submap_b = 4;
  edge.match.edges[0].information(0, 1) = edge.match.edges[0].information(1, 0) = 7;
  const Json json = ToJson(edge);
  ASSERT_EQ(json["edges"].size(), 1u);
  EXPECT_EQ(json["edges"][0]["submap_b"], 4);
  EXPECT_EQ(json["edges"][0]["information"].size(), 21u);
  EXPECT_EQ(json["edges"][0]["information"][1], 7);
}

TEST(Json, OfBytesThatAreNoTextIsStillADocument) {
  v1::Session session;
  session.set_sensor("\x1b[2J\xff");
  const std::string text = Text(ToJson(session));
  EXPECT_EQ(text.find_first_of("\x1b\xff"), std::string::npos);
  EXPECT_TRUE(Json::accept(text)) << text;
}

}  // namespace
}  // namespace isthmus::cli
