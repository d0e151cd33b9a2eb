// The promises of map_store.h about matches, held by every store.
#include <gtest/gtest.h>

#include <limits>

#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

class MatchContract : public MapStoreContract {};

TEST_P(MatchContract, KeepsTheLastMatchOfEveryPair) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1"), MakeSession("carol-1")},
       .matches = {MakeMatch("bob-1", "carol-1"), MakeMatch("alice-1", "carol-1")}});
  Match newer = MakeMatch("alice-1", "carol-1");
  newer.state = MatchState::kAccepted;
  newer.stages = {{"fpfh", 1.5}};
  Put({.matches = {newer, MakeMatch("alice-1", "bob-1")}});
  const auto matches = store_->ListMatches();
  ASSERT_EQ(matches->size(), 3u);
  EXPECT_EQ((*matches)[0].b, bob_);
  EXPECT_EQ((*matches)[1].state, MatchState::kAccepted);
  ASSERT_EQ((*matches)[1].stages.size(), 1u);
  EXPECT_EQ((*matches)[1].stages[0].stage, "fpfh");
  const Match expected = MakeMatch("bob-1", "carol-1");
  const Match& match = (*matches)[2];
  EXPECT_EQ(match.a, expected.a);
  EXPECT_EQ(match.b, expected.b);
  EXPECT_TRUE(Near(match.T_a_b, expected.T_a_b));
  EXPECT_EQ(match.state, expected.state);
  EXPECT_EQ(match.reason, expected.reason);
  EXPECT_EQ(match.detail, expected.detail);
  EXPECT_EQ(match.confidence, expected.confidence);
  EXPECT_EQ(match.overlap, expected.overlap);
  EXPECT_EQ(match.inliers, expected.inliers);
  EXPECT_EQ(match.residual_m, expected.residual_m);
  EXPECT_EQ(match.free_space, expected.free_space);
  EXPECT_EQ(match.comparisons, expected.comparisons);
  EXPECT_EQ(match.runner_up, expected.runner_up);
  EXPECT_EQ(match.matcher, expected.matcher);
  EXPECT_EQ(match.submaps_a, expected.submaps_a);
  EXPECT_EQ(match.submaps_b, expected.submaps_b);
  EXPECT_EQ(match.computed_ns, expected.computed_ns);
  EXPECT_EQ(match.inlier_ratio, expected.inlier_ratio);
  EXPECT_EQ(match.shared_area_m2, expected.shared_area_m2);
  EXPECT_EQ(match.observability, expected.observability);
  EXPECT_EQ(match.odometry_residual, expected.odometry_residual);
  EXPECT_EQ(match.candidates, expected.candidates);
  ASSERT_EQ(match.stages.size(), 2u);
  EXPECT_EQ(match.stages[1].stage, "vgicp");
  EXPECT_EQ(match.stages[1].ms, 3.25);
}

TEST_P(MatchContract, KeepsTheEdgesOfAMatch) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
       .matches = {MakeMatch("alice-1", "bob-1")}});
  const Match expected = MakeMatch("alice-1", "bob-1");
  const auto kept = store_->ListMatches();
  ASSERT_TRUE(kept.ok()) << kept.status();
  ASSERT_EQ(kept->at(0).edges.size(), expected.edges.size());
  for (size_t i = 0; i < expected.edges.size(); ++i) {
    const SubmapEdge& edge = kept->at(0).edges[i];
    EXPECT_EQ(edge.submap_a, expected.edges[i].submap_a);
    EXPECT_EQ(edge.submap_b, expected.edges[i].submap_b);
    EXPECT_TRUE(Near(edge.T_a_b, expected.edges[i].T_a_b));
    EXPECT_EQ(edge.information, expected.edges[i].information);
  }
  Match without = expected;
  without.edges.clear();
  Put({.matches = {without}});
  EXPECT_TRUE(store_->ListMatches()->at(0).edges.empty());
}

TEST_P(MatchContract, KeepsTheRivalsOfAMatch) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
       .matches = {MakeMatch("alice-1", "bob-1")}});
  const RivalMatch expected = MakeMatch("alice-1", "bob-1").rivals[0];
  const auto kept = store_->ListMatches();
  ASSERT_TRUE(kept.ok()) << kept.status();
  ASSERT_EQ(kept->at(0).rivals.size(), 2u);
  const RivalMatch& rival = kept->at(0).rivals[0];
  EXPECT_TRUE(Near(rival.T_a_b, expected.T_a_b));
  EXPECT_EQ(rival.state, expected.state);
  EXPECT_EQ(rival.reason, expected.reason);
  EXPECT_EQ(rival.confidence, expected.confidence);
  EXPECT_EQ(rival.matcher, expected.matcher);
  EXPECT_EQ(rival.overlap, expected.overlap);
  EXPECT_EQ(rival.free_space, expected.free_space);
  EXPECT_EQ(rival.comparisons, expected.comparisons);
  EXPECT_EQ(rival.shared_area_m2, expected.shared_area_m2);
  ASSERT_EQ(rival.edges.size(), 1u);
  EXPECT_EQ(rival.edges[0].submap_b, 6u);
  EXPECT_EQ(kept->at(0).rivals[1].state, MatchState::kRejected);
  EXPECT_TRUE(kept->at(0).rivals[1].edges.empty());
  Match without = MakeMatch("alice-1", "bob-1");
  without.rivals.clear();
  Put({.matches = {without}});
  EXPECT_TRUE(store_->ListMatches()->at(0).rivals.empty());
}

TEST_P(MatchContract, RefusesARivalThatIsNotFinite) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  Match match = MakeMatch("alice-1", "bob-1");
  match.rivals[0].T_a_b = Pose(Eigen::Vector3d(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  EXPECT_EQ(store_->Write({.matches = {match}}).code(), StatusCode::kInvalidArgument);
}

TEST_P(MatchContract, DoesNotKeepWhatFollowsFromOtherMatches) {
  Match match = MakeMatch("alice-1", "bob-1");
  match.cycle_m = 0.5;
  match.cycle_deg = 1;
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}, .matches = {match}});
  EXPECT_EQ(store_->ListMatches()->at(0).cycle_m, -1);
  EXPECT_EQ(store_->ListMatches()->at(0).cycle_deg, -1);
}

TEST_P(MatchContract, RefusesEdgesThatAreNotFiniteOrSymmetric) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  Match match = MakeMatch("alice-1", "bob-1");
  match.edges[1].information(2, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CodeOf({.matches = {match}}), StatusCode::kInvalidArgument);
  match = MakeMatch("alice-1", "bob-1");
  match.edges[0].T_a_b = Pose(Eigen::Vector3d(0, std::numeric_limits<double>::infinity(), 0));
  EXPECT_EQ(CodeOf({.matches = {match}}), StatusCode::kInvalidArgument);
  match = MakeMatch("alice-1", "bob-1");
  match.edges[0].information(0, 5) += 1;  // Not symmetric.
  EXPECT_EQ(CodeOf({.matches = {match}}), StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->ListMatches()->empty());
}

INSTANTIATE_TEST_SUITE_P(Stores, MatchContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

}  // namespace
}  // namespace isthmus::storage
