#include "client/console/json.h"

#include <gtest/gtest.h>

#include <limits>

namespace isthmus::cli {
namespace {

TEST(MatchJson, WhatIsNotKnownIsNull) {
  MatchEdge edge;
  edge.match.residual_m = std::numeric_limits<double>::quiet_NaN();
  edge.match.overlap = 0;
  const Json json = Json::parse(ToJson(edge).dump());
  EXPECT_EQ(json["overlap"], 0) << "nothing in common is known";
  for (const char* key :
       {"inliers", "inlier_ratio", "residual_m", "free_space", "comparisons", "runner_up",
        "shared_area_m2", "observability", "odometry_residual", "cycle_m", "cycle_deg"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  EXPECT_FALSE(json.contains("edges"));
}

TEST(MatchJson, HasEveryNumberAndTheEdgesIfAskedFor) {
  MatchEdge edge;
  edge.match.inlier_ratio = 0.5;
  edge.match.shared_area_m2 = 300;
  edge.match.observability = 0.25;
  edge.match.odometry_residual = 2;
  edge.match.cycle_m = 0.125;
  edge.match.cycle_deg = 1;
  edge.match.candidates = 8;
  edge.match.submaps_a = 3;
  edge.match.edges.resize(1);
  edge.match.edges[0].submap_b = 4;
  edge.match.edges[0].information(0, 1) = edge.match.edges[0].information(1, 0) = 7;
  const Json json = Json::parse(ToJson(edge, true).dump());
  EXPECT_EQ(json["inlier_ratio"], 0.5);
  EXPECT_EQ(json["shared_area_m2"], 300);
  EXPECT_EQ(json["observability"], 0.25);
  EXPECT_EQ(json["odometry_residual"], 2);
  EXPECT_EQ(json["cycle_m"], 0.125);
  EXPECT_EQ(json["cycle_deg"], 1);
  EXPECT_EQ(json["candidates"], 8);
  EXPECT_EQ(json["submaps_a"], 3);
  ASSERT_EQ(json["edges"].size(), 1u);
  EXPECT_EQ(json["edges"][0]["submap_b"], 4);
  EXPECT_EQ(json["edges"][0]["information"].size(), 21u);
  EXPECT_EQ(json["edges"][0]["information"][1], 7);
}

}  // namespace
}  // namespace isthmus::cli
