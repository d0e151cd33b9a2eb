// Matches that others settle: the map is made with them, and matches stay as computed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

// 40 m from the one before.
std::shared_ptr<Submap> SubmapOf(const std::string& robot, uint32_t index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId(robot + "-1"), index};
  submap->robot = RobotId(robot);
  submap->T_odom_submap = Pose(Eigen::Vector3d(40.0 * index, 0, 0));
  submap->keyframes = {{1 + index, 1 + index, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  return submap;
}

SubmapEdge EdgeOf(uint32_t submap_a, uint32_t submap_b, double x) {
  const double along = x + 40.0 * submap_b - 40.0 * submap_a;
  return {submap_a, submap_b, Pose(Eigen::Vector3d(along, 0, 0)), Matrix6d::Identity()};
}

// On one submap of each.
Match OpenMatch(const std::string& a, const std::string& b, double x, uint32_t submap_a,
                uint32_t submap_b) {
  Match match;
  match.a = SessionId(a + "-1");
  match.b = SessionId(b + "-1");
  match.T_a_b = Pose(Eigen::Vector3d(x, 0, 0));
  match.state = MatchState::kAmbiguous;
  match.reason = MatchReason::kAmbiguous;
  match.confidence = 0.8;
  match.matcher = GuessSource::kBirdsEye;
  match.edges = {EdgeOf(submap_a, submap_b, x)};
  return match;
}

// bob and carol are merged; alice met both, and with bob it is her second best place that is right.
class PipelineGroups : public PlacedMapTest {
 protected:
  void SetUp() override {
    storage::WriteBatch batch;
    for (const char* robot : {"alice", "bob", "carol"}) {
      batch.sessions.push_back(SessionOf(robot));
      for (uint32_t k = 0; k < 3; ++k) batch.submaps.push_back(SubmapOf(robot, k));
    }
    ASSERT_NO_FATAL_FAILURE(Begin(batch));
    Match accepted = OpenMatch("bob", "carol", 10, 0, 0);
    accepted.state = MatchState::kAccepted;
    accepted.reason = MatchReason::kOk;
    ASSERT_TRUE(map_.PutMatch(accepted).ok());
    Match second = OpenMatch("alice", "bob", 25, 0, 0);
    RivalMatch& rival = second.rivals.emplace_back();
    rival.T_a_b = Pose(Eigen::Vector3d(5, 0, 0));
    rival.state = MatchState::kAmbiguous;
    rival.reason = MatchReason::kAmbiguous;
    rival.confidence = 0.7;
    rival.edges = {EdgeOf(0, 0, 5)};
    second.confidence = 0.5;
    ASSERT_TRUE(map_.PutMatch(second).ok());
  }

  absl::Status Meet() { return map_.PutMatch(OpenMatch("alice", "carol", 15, 2, 2)); }

  static void ExpectSettled(const MapWriter& map) {
    const MapWriter::View view = map.view();
    const Match* match = view->EffectiveMatch({SessionId("alice-1"), SessionId("bob-1")});
    ASSERT_NE(match, nullptr);
    EXPECT_EQ(match->state, MatchState::kAccepted);
    EXPECT_EQ(match->reason, MatchReason::kGroup);
    EXPECT_EQ(match->T_a_b.translation().x(), 5);
    EXPECT_THAT(match->detail, HasSubstr("Settled by way of carol-1"));
    const Placement* alice = view->PlacementOf(SessionId("alice-1"));
    const Placement* bob = view->PlacementOf(SessionId("bob-1"));
    ASSERT_TRUE(alice != nullptr && bob != nullptr);
    EXPECT_EQ(alice->component, bob->component);
    const Pose T_alice_bob = alice->T_map_odom.Inverse() * bob->T_map_odom;
    EXPECT_NEAR(T_alice_bob.translation().x(), 5, 0.01);
  }

  MatchReason ReasonOfAliceAndBob() const {
    const MapWriter::View view = map_.view();
    return view->EffectiveMatch({SessionId("alice-1"), SessionId("bob-1")})->reason;
  }
};

TEST_F(PipelineGroups, ASecondBestPlaceIsTakenAndTheMatchKeptAsComputed) {
  EXPECT_EQ(ReasonOfAliceAndBob(), MatchReason::kAmbiguous);
  ASSERT_TRUE(Meet().ok());
  map_.WaitUntilPlaced();
  ExpectSettled(map_);
  const auto stored = store_->ListMatches();
  ASSERT_EQ(stored->size(), 3u);
  EXPECT_EQ(stored->at(0).reason, MatchReason::kAmbiguous);
  EXPECT_EQ(stored->at(0).T_a_b.translation().x(), 25);
  EXPECT_EQ(stored->at(0).rivals.size(), 1u);
}

TEST_F(PipelineGroups, ItIsTheSameAfterARestart) {
  ASSERT_TRUE(Meet().ok());
  map_.WaitUntilPlaced();
  const int64_t revision = map_.view()->revision->revision;
  SubmapCache submaps(store_.get(), size_t{1} << 30, nullptr);
  Activity activity;
  MapWriter again(store_.get(), &submaps, &activity, &Clock::System());
  ASSERT_TRUE(again.Load().ok());
  PlacementThread placement(&again, &activity, store_.get(), &Clock::System(), {});
  again.WaitUntilPlaced();
  ExpectSettled(again);
  EXPECT_EQ(again.view()->revision->revision, revision) << "nothing has moved";
}

TEST_F(PipelineGroups, ItEndsWithWhatItRestsOn) {
  ASSERT_TRUE(Meet().ok());
  ASSERT_EQ(ReasonOfAliceAndBob(), MatchReason::kGroup);
  ManualDecision rejected;
  rejected.a = SessionId("alice-1");
  rejected.b = SessionId("carol-1");
  rejected.kind = ManualDecisionKind::kReject;
  ASSERT_TRUE(map_.PutDecisions({.manual_decisions = {rejected}}).ok());
  EXPECT_EQ(ReasonOfAliceAndBob(), MatchReason::kAmbiguous);
  ASSERT_TRUE(map_.PutDecisions({.withdrawn = {{rejected.a, rejected.b}}}).ok());
  EXPECT_EQ(ReasonOfAliceAndBob(), MatchReason::kGroup);
  ASSERT_TRUE(map_.RemoveSession(SessionId("carol-1")).ok());
  EXPECT_EQ(ReasonOfAliceAndBob(), MatchReason::kAmbiguous);
}

}  // namespace
}  // namespace isthmus::server
