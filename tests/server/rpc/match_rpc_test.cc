// A person's decision on matches, over a socket.
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class MatchRpcTest : public RpcTest {
 protected:
  void SetUp() override {
    RpcTest::SetUp();
    Match match;
    match.a = SessionId("alice-1");
    match.b = SessionId("bob-1");
    match.state = MatchState::kAccepted;
    MatchEdge edge{match, RobotId("alice"), RobotId("bob"), true};
    edge.manual_decision = {
        match.a, match.b, ManualDecisionKind::kAccept, Pose(), "seen from the gallery", 77};
    pipeline_.decided = DecidedMatch{9, edge};
  }

  grpc::Status Decide(const v1::DecideMatchRequest& request) {
    response_.Clear();
    return stubs_->edits->DecideMatch(NewContext().get(), request, &response_);
  }

  v1::DecideMatchResponse response_;
};

v1::DecideMatchRequest Request(v1::DecideMatchRequest::Decision decision) {
  v1::DecideMatchRequest request;
  request.set_robot_a("alice");
  request.set_session_b("bob-1");
  request.set_decision(decision);
  request.set_note("why");
  return request;
}

TEST_F(MatchRpcTest, TheDecisionArrivesAndTheMatchComesBackAsItCounts) {
  EXPECT_GRPC_OK(Decide(Request(v1::DecideMatchRequest::ACCEPT)));
  ASSERT_EQ(pipeline_.match_decisions.size(), 1u);
  EXPECT_EQ(pipeline_.match_decisions[0].robot_a, RobotId("alice"));
  EXPECT_EQ(pipeline_.match_decisions[0].session_b, SessionId("bob-1"));
  EXPECT_EQ(pipeline_.match_decisions[0].kind, ManualDecisionKind::kAccept);
  EXPECT_EQ(pipeline_.match_decisions[0].note, "why");
  EXPECT_EQ(response_.revision(), 9);
  EXPECT_EQ(response_.match().state(), v1::Match::ACCEPTED);
  EXPECT_TRUE(response_.match().in_tree());
  EXPECT_EQ(response_.match().manual_decision().kind(), v1::ManualDecision::ACCEPT);
  EXPECT_EQ(response_.match().manual_decision().note(), "seen from the gallery");
  EXPECT_EQ(response_.match().manual_decision().given_ns(), 77);
}

TEST_F(MatchRpcTest, EveryDecisionIsTold) {
  v1::DecideMatchRequest set = Request(v1::DecideMatchRequest::SET);
  set.mutable_t_a_b()->mutable_translation()->set_x(4);
  EXPECT_GRPC_OK(Decide(set));
  EXPECT_GRPC_OK(Decide(Request(v1::DecideMatchRequest::REJECT)));
  EXPECT_GRPC_OK(Decide(Request(v1::DecideMatchRequest::WITHDRAW)));
  ASSERT_EQ(pipeline_.match_decisions.size(), 3u);
  EXPECT_EQ(pipeline_.match_decisions[0].kind, ManualDecisionKind::kSet);
  EXPECT_EQ(pipeline_.match_decisions[0].T_a_b.translation().x(), 4);
  EXPECT_EQ(pipeline_.match_decisions[1].kind, ManualDecisionKind::kReject);
  EXPECT_FALSE(pipeline_.match_decisions[2].kind.has_value());
}

TEST_F(MatchRpcTest, APairWithoutAnyMatchIsAnsweredToo) {
  pipeline_.decided->edge = {};
  pipeline_.decided->edge.match.a = SessionId("alice-1");
  EXPECT_GRPC_OK(Decide(Request(v1::DecideMatchRequest::WITHDRAW)));
  EXPECT_EQ(response_.match().session_a(), "alice-1");
  EXPECT_EQ(response_.match().state(), v1::Match::NOT_YET);
  EXPECT_EQ(response_.match().reason(), v1::Match::REASON_UNSPECIFIED);
  EXPECT_FALSE(response_.match().has_manual_decision());
}

TEST_F(MatchRpcTest, WhatCannotBeMeantIsRefused) {
  EXPECT_GRPC_ERROR(Decide(Request(v1::DecideMatchRequest::DECISION_UNSPECIFIED)), INVALID_ARGUMENT,
                    "ACCEPT, REJECT, SET or WITHDRAW");
  v1::DecideMatchRequest set = Request(v1::DecideMatchRequest::SET);
  EXPECT_GRPC_ERROR(Decide(set), INVALID_ARGUMENT, "t_a_b");
  set.mutable_t_a_b()->mutable_rotation();
  EXPECT_GRPC_ERROR(Decide(set), INVALID_ARGUMENT, "all zeros");
  EXPECT_TRUE(pipeline_.match_decisions.empty());
  pipeline_.decided = absl::FailedPreconditionError("nothing was found");
  EXPECT_GRPC_ERROR(Decide(Request(v1::DecideMatchRequest::ACCEPT)), FAILED_PRECONDITION,
                    "nothing was found");
}

}  // namespace
}  // namespace isthmus::rpc
