// The RPCs that open, list and end sessions, over a socket.
#include <limits>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class SessionRpcTest : public RpcTest {
 protected:
  grpc::Status Create(const v1::CreateSessionRequest& request, v1::Session* session) {
    return stubs_->sessions->CreateSession(NewContext().get(), request, session);
  }
};

v1::CreateSessionRequest Alice() {
  v1::CreateSessionRequest request;
  request.set_robot("alice");
  request.set_sensor("vlp16");
  return request;
}

TEST_F(SessionRpcTest, CreateReturnsTheSessionWithItsExtrinsicNormalised) {
  v1::CreateSessionRequest request = Alice();
  request.set_odometry(v1::ODOMETRY_ALOAM);
  request.mutable_t_base_sensor()->mutable_translation()->set_z(0.5);
  request.mutable_t_base_sensor()->mutable_rotation()->set_w(2);
  v1::Session session;
  EXPECT_GRPC_OK(Create(request, &session));
  EXPECT_EQ(session.id(), "alice-1");
  EXPECT_EQ(session.robot(), "alice");
  EXPECT_EQ(session.sensor(), "vlp16");
  EXPECT_EQ(session.odometry(), v1::ODOMETRY_ALOAM);
  EXPECT_EQ(session.state(), v1::Session::ACTIVE);
  EXPECT_EQ(session.created_ns(), 1000);
  EXPECT_EQ(session.t_base_sensor().translation().z(), 0.5);
  EXPECT_EQ(session.t_base_sensor().rotation().w(), 1);
  EXPECT_FALSE(session.has_component());
  EXPECT_FALSE(session.has_t_map_odom());
  EXPECT_EQ(session.segment(), 1u);
  EXPECT_EQ(session.first_segment(), "");
  EXPECT_EQ(session.segments(), 3u);
  EXPECT_EQ(session.scan_counts().ok(), 21u);
  EXPECT_EQ(session.scan_counts().degenerate(), 22u);
  EXPECT_EQ(session.scan_counts().lost(), 23u);
  EXPECT_EQ(session.scan_counts().rejected(), 24u);
  EXPECT_EQ(session.lost_since_ns(), 25);
}

TEST_F(SessionRpcTest, AnAbsentExtrinsicIsIdentity) {
  v1::Session session;
  EXPECT_GRPC_OK(Create(Alice(), &session));
  EXPECT_EQ(session.t_base_sensor().rotation().w(), 1);
  EXPECT_EQ(session.t_base_sensor().translation().x(), 0);
}

TEST_F(SessionRpcTest, ExtrinsicsThatAreNoPosesAreRefused) {
  v1::Session session;
  v1::CreateSessionRequest request = Alice();
  request.mutable_t_base_sensor()->mutable_translation()->set_x(
      std::numeric_limits<double>::quiet_NaN());
  EXPECT_GRPC_ERROR(Create(request, &session), INVALID_ARGUMENT, "t_base_sensor");

  request = Alice();
  request.mutable_t_base_sensor()->mutable_rotation();
  EXPECT_GRPC_ERROR(Create(request, &session), INVALID_ARGUMENT, "all zeros");

  request.mutable_t_base_sensor()->mutable_rotation()->set_x(
      std::numeric_limits<double>::infinity());
  EXPECT_GRPC_ERROR(Create(request, &session), INVALID_ARGUMENT, "not finite");

  request = Alice();
  request.mutable_t_base_sensor()->mutable_translation()->set_y(1e12);
  EXPECT_GRPC_ERROR(Create(request, &session), INVALID_ARGUMENT, "metres");
}

TEST_F(SessionRpcTest, AnOdometryThatIsNotKnownIsRefused) {
  v1::Session session;
  v1::CreateSessionRequest request = Alice();
  request.set_odometry(static_cast<v1::Odometry>(99));
  EXPECT_GRPC_ERROR(Create(request, &session), INVALID_ARGUMENT, "continuous");
  request.set_odometry(v1::ODOMETRY_UNSPECIFIED);
  EXPECT_GRPC_OK(Create(request, &session));
  EXPECT_EQ(session.odometry(), v1::ODOMETRY_UNSPECIFIED);
}

TEST_F(SessionRpcTest, ErrorsOfThePipelineKeepCodeAndMessage) {
  v1::Session session;
  EXPECT_GRPC_ERROR(Create({}, &session), INVALID_ARGUMENT, "no name");
  v1::GetSessionRequest get;
  get.set_session("carol-9");
  EXPECT_GRPC_ERROR(stubs_->sessions->GetSession(NewContext().get(), get, &session), NOT_FOUND,
                    "carol-9");
  v1::FinishSessionRequest finish;
  finish.set_session("carol-9");
  EXPECT_GRPC_ERROR(stubs_->sessions->FinishSession(NewContext().get(), finish, &session),
                    NOT_FOUND, "carol-9");
  v1::DeleteSessionRequest erase;
  erase.set_session("carol-9");
  v1::DeleteSessionResponse nothing;
  EXPECT_GRPC_ERROR(stubs_->edits->DeleteSession(NewContext().get(), erase, &nothing), NOT_FOUND,
                    "carol-9");
}

TEST_F(SessionRpcTest, AMessageTooLongForATrailerIsCutNotLost) {
  pipeline_.undo = absl::NotFoundError(std::string(100'000, 'x'));
  v1::UndoRevisionResponse undone;
  EXPECT_GRPC_ERROR(stubs_->edits->UndoRevision(NewContext().get(), {}, &undone), NOT_FOUND, "xxx");
}

TEST_F(SessionRpcTest, SessionsAreListedFinishedAndDeleted) {
  const std::string alice = stubs_->NewSession("alice");
  const std::string bob = stubs_->NewSession("bob");
  v1::ListSessionsResponse list;
  EXPECT_GRPC_OK(Merged(stubs_->sessions->ListSessions(NewContext().get(), {}), &list));
  ASSERT_EQ(list.sessions_size(), 2);
  EXPECT_EQ(list.sessions(0).id(), alice);
  EXPECT_EQ(list.sessions(1).id(), bob);

  v1::FinishSessionRequest finish;
  finish.set_session(alice);
  v1::Session session;
  EXPECT_GRPC_OK(stubs_->sessions->FinishSession(NewContext().get(), finish, &session));
  EXPECT_EQ(session.state(), v1::Session::FINISHED);
  EXPECT_EQ(session.finished_ns(), 2000);

  v1::DeleteSessionRequest erase;
  erase.set_session(alice);
  v1::DeleteSessionResponse nothing;
  EXPECT_GRPC_OK(stubs_->edits->DeleteSession(NewContext().get(), erase, &nothing));
  EXPECT_GRPC_OK(Merged(stubs_->sessions->ListSessions(NewContext().get(), {}), &list));
  ASSERT_EQ(list.sessions_size(), 1);
  EXPECT_EQ(list.sessions(0).id(), bob);
}

}  // namespace
}  // namespace isthmus::rpc
