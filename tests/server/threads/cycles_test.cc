// Matches that contradict each other: the map is made without them, and matches stay as computed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<Submap> SubmapAtOrigin(const std::string& robot) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId(robot + "-1"), 0};
  submap->robot = RobotId(robot);
  submap->keyframes = {{1, 1, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  return submap;
}

Match MakeMatch(const std::string& a, const std::string& b, double x) {
  Match match;
  match.a = SessionId(a + "-1");
  match.b = SessionId(b + "-1");
  match.T_a_b = Pose(Eigen::Vector3d(x, 0, 0));
  match.state = MatchState::kAccepted;
  match.reason = MatchReason::kOk;
  match.confidence = 0.9;
  match.matcher = GuessSource::kBirdsEye;
  return match;
}

// alice, bob and carol; the match of bob and carol is 30 m off.
class PipelineCycles : public PlacedMapTest {
 protected:
  void SetUp() override {
    storage::WriteBatch batch;
    for (const char* robot : {"alice", "bob", "carol"}) {
      batch.sessions.push_back(SessionOf(robot));
      batch.submaps.push_back(SubmapAtOrigin(robot));
    }
    ASSERT_NO_FATAL_FAILURE(Begin(batch));
    ASSERT_TRUE(map_.PutMatch(MakeMatch("alice", "bob", 1)).ok());
    ASSERT_TRUE(map_.PutMatch(MakeMatch("alice", "carol", 2)).ok());
  }

  absl::Status Contradict() { return map_.PutMatch(MakeMatch("bob", "carol", 31)); }

  std::string Reason(const std::string& a, const std::string& b) const {
    const MapWriter::View view = map_.view();
    const Match* match = view->EffectiveMatch({SessionId(a + "-1"), SessionId(b + "-1")});
    return match != nullptr ? ToString(match->reason) : "none";
  }
  size_t Components() {
    map_.WaitUntilPlaced();
    const MapWriter::View view = map_.view();
    uint32_t last = 0;
    for (const Placement& placement : view->revision->placements) {
      last = std::max(last, placement.component);
    }
    return last + 1;
  }
};

TEST_F(PipelineCycles, MatchesThatDisagreeCarryNothingButAreKeptAsComputed) {
  ASSERT_EQ(Components(), 1u);
  ASSERT_TRUE(Contradict().ok());
  EXPECT_EQ(Reason("alice", "bob"), "CYCLE");
  EXPECT_EQ(Reason("alice", "carol"), "CYCLE");
  EXPECT_EQ(Reason("bob", "carol"), "CYCLE");
  EXPECT_EQ(Components(), 3u);
  EXPECT_TRUE(map_.view()->tree->empty());
  const auto stored = store_->ListMatches();
  ASSERT_EQ(stored->size(), 3u);
  for (const Match& match : *stored) {
    EXPECT_EQ(match.state, MatchState::kAccepted);
    EXPECT_EQ(match.reason, MatchReason::kOk);
  }
  const MapWriter::View view = map_.view();
  for (const auto& [pair, match] : view->matches) EXPECT_EQ(match.reason, MatchReason::kOk);
  ASSERT_EQ((*map_.view()->effective).size(), 3u);
  EXPECT_NEAR((*map_.view()->effective)[0].cycle_m, 30, 1e-9);
}

TEST_F(PipelineCycles, TheyComeBackWithWhatSpokeAgainstThem) {
  ASSERT_TRUE(Contradict().ok());
  ASSERT_TRUE(map_.PutMatch(MakeMatch("bob", "carol", 1.1)).ok()) << "computed anew";
  EXPECT_EQ(Reason("alice", "bob"), "OK");
  EXPECT_EQ(Reason("bob", "carol"), "OK");
  EXPECT_EQ(Components(), 1u);
  EXPECT_NEAR((*map_.view()->effective)[0].cycle_m, 0.1, 1e-9);
  ASSERT_TRUE(Contradict().ok());
  ASSERT_EQ(Components(), 3u);
  ASSERT_TRUE(map_.RemoveSession(SessionId("carol-1")).ok());
  EXPECT_EQ(Reason("alice", "bob"), "OK");
  EXPECT_EQ(Components(), 1u);
}

TEST_F(PipelineCycles, ADecisionByHandStands) {
  ASSERT_TRUE(Contradict().ok());
  ManualDecision manual_decision;
  manual_decision.a = SessionId("bob-1");
  manual_decision.b = SessionId("carol-1");
  manual_decision.kind = ManualDecisionKind::kReject;
  ASSERT_TRUE(map_.PutDecisions({.manual_decisions = {manual_decision}}).ok());
  EXPECT_EQ(Reason("alice", "bob"), "OK");
  EXPECT_EQ(Components(), 1u);
  ASSERT_TRUE(map_.PutDecisions({.withdrawn = {{manual_decision.a, manual_decision.b}}}).ok());
  EXPECT_EQ(Components(), 3u);
  manual_decision.kind = ManualDecisionKind::kAccept;
  manual_decision.T_a_b = Pose(Eigen::Vector3d(1, 0, 0));
  ASSERT_TRUE(map_.PutDecisions({.manual_decisions = {manual_decision}}).ok())
      << "in agreement with the others";
  EXPECT_EQ(Reason("bob", "carol"), "BY_HAND");
  EXPECT_EQ(Reason("alice", "bob"), "OK");
  EXPECT_EQ(Components(), 1u);
}

TEST_F(PipelineCycles, TheyAreFoundAgainAfterARestart) {
  ASSERT_TRUE(Contradict().ok());
  ASSERT_EQ(Components(), 3u);
  const int64_t revision = map_.view()->revision->revision;
  SubmapCache submaps(store_.get(), size_t{1} << 30, nullptr);
  Activity activity;
  MapWriter again(store_.get(), &submaps, &activity, &Clock::System());
  ASSERT_TRUE(again.Load().ok());
  PlacementThread placement(&again, &activity, store_.get(), &Clock::System(), {});
  again.WaitUntilPlaced();
  EXPECT_EQ(again.view()->revision->revision, revision) << "nothing has moved";
  const MapWriter::View view = again.view();
  const Match* match = view->EffectiveMatch({SessionId("alice-1"), SessionId("bob-1")});
  ASSERT_NE(match, nullptr);
  EXPECT_THAT(match->detail, HasSubstr("Going round alice-1, bob-1, carol-1, alice-1"));
}

}  // namespace
}  // namespace isthmus::server
