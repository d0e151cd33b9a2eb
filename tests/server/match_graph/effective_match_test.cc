#include "server/match_graph/effective_match.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::match_graph {
namespace {

using ::testing::HasSubstr;

Match Ambiguous() {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.T_a_b = Pose(Eigen::Vector3d(5, 0, 0));
  match.state = MatchState::kAmbiguous;
  match.reason = MatchReason::kAmbiguous;
  match.detail = "two rooms look alike";
  match.confidence = 0.2;
  match.overlap = 0.4;
  match.matcher = GuessSource::kBirdsEye;
  return match;
}

ManualDecision MakeDecision(ManualDecisionKind kind, double x) {
  return {SessionId("alice-1"),           SessionId("bob-1"),     kind,
          Pose(Eigen::Vector3d(x, 0, 0)), "measured with a tape", 7};
}

TEST(EffectiveMatch, AnAcceptedTransformStaysWhateverIsComputedLater) {
  Match later = Ambiguous();
  later.T_a_b = Pose(Eigen::Vector3d(-9, 0, 0));
  const Match match = EffectiveMatch(MakeDecision(ManualDecisionKind::kAccept, 5), later);
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.T_a_b.translation().x(), 5);
  EXPECT_EQ(match.confidence, 1);
  EXPECT_EQ(match.overlap, 0.4) << "what was computed stays for the reader";
  EXPECT_EQ(match.matcher, GuessSource::kBirdsEye);
  EXPECT_EQ(match.reason, MatchReason::kByHand);
  EXPECT_THAT(match.detail, HasSubstr("measured with a tape"));
  EXPECT_THAT(match.detail, HasSubstr("two rooms look alike"));
}

TEST(EffectiveMatch, ATransformGivenByHandNeedsNoComputedMatch) {
  const Match match = EffectiveMatch(MakeDecision(ManualDecisionKind::kSet, 3), std::nullopt);
  EXPECT_EQ(match.a, SessionId("alice-1"));
  EXPECT_EQ(match.b, SessionId("bob-1"));
  EXPECT_EQ(match.state, MatchState::kAccepted);
  EXPECT_EQ(match.T_a_b.translation().x(), 3);
  EXPECT_EQ(match.matcher, GuessSource::kByHand);
}

TEST(EffectiveMatch, ARejectedPairIsNotJoinedByAnAcceptedMatch) {
  Match accepted = Ambiguous();
  accepted.state = MatchState::kAccepted;
  accepted.confidence = 0.9;
  const Match match = EffectiveMatch(MakeDecision(ManualDecisionKind::kReject, 5), accepted);
  EXPECT_EQ(match.state, MatchState::kRejected);
  EXPECT_EQ(match.confidence, 0);
}

}  // namespace
}  // namespace isthmus::match_graph
