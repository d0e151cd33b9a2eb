// StreamScans over a socket: one acknowledgement per scan in order, back-pressure, half-close,
// lost links, take-over.
#include <thread>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using Wire = grpc::ClientReaderWriter<v1::StreamScansRequest, v1::StreamScansResponse>;
using Response = v1::StreamScansResponse;

v1::StreamScansRequest Hello(const std::string& session) {
  v1::StreamScansRequest request;
  request.set_session(session);
  return request;
}

v1::StreamScansRequest Scan(uint64_t sequence) {
  v1::StreamScansRequest request;
  request.mutable_scan()->set_sequence(sequence);
  request.mutable_scan()->set_end_stamp_ns(static_cast<int64_t>(sequence) * 100'000'000);
  v1::PointCloud& cloud = *request.mutable_scan()->mutable_cloud();
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(1);
  cloud.set_stride(12);
  cloud.set_data(std::string(12, '\0'));
  return request;
}

class StreamScansTest : public RpcTest {
 protected:
  static constexpr size_t kWindow = 8;

  StreamScansTest() : RpcTest(SmallWindow()), session_(stubs_->NewSession("alice")) {}

  static ServerOptions SmallWindow() {
    ServerOptions options;
    options.scan_window = kWindow;
    return options;
  }

  std::unique_ptr<Wire> Open() {
    context_ = NewContext();
    return stubs_->sessions->StreamScans(context_.get());
  }
  // Opens a stream of the session.
  std::unique_ptr<Wire> OpenSession() {
    auto wire = Open();
    wire->Write(Hello(session_));
    return wire;
  }
  static std::vector<Response> ReadAll(Wire& wire) {
    std::vector<Response> all;
    Response response;
    while (wire.Read(&response)) all.push_back(response);
    return all;
  }

  const std::string session_;
  std::unique_ptr<grpc::ClientContext> context_;  // The last stream's.
};

TEST_F(StreamScansTest, EveryScanIsAcknowledgedInOrder) {
  auto wire = OpenSession();
  for (uint64_t i = 1; i <= 30; ++i) {
    ASSERT_TRUE(wire->Write(Scan(i)));
    Response ack;
    ASSERT_TRUE(wire->Read(&ack));
    EXPECT_EQ(ack.sequence(), i);
    EXPECT_EQ(ack.outcome(), Response::PROCESSED);
    EXPECT_EQ(ack.tracking(), v1::TRACKING_OK);
    EXPECT_EQ(ack.t_odom_sensor().translation().x(), static_cast<double>(i));
    EXPECT_FALSE(ack.has_t_map_odom());
    EXPECT_EQ(ack.timing().total_ms(), 3.5);
    EXPECT_EQ(ack.segment(), 2u);
    EXPECT_EQ(ack.segment_session(), session_ + ".2");
    EXPECT_EQ(ack.lost_since_ns(), 7);
    EXPECT_EQ(ack.scan_counts().ok(), 11u);
    EXPECT_EQ(ack.scan_counts().degenerate(), 12u);
    EXPECT_EQ(ack.scan_counts().lost(), 13u);
    EXPECT_EQ(ack.scan_counts().rejected(), 14u);
    ASSERT_EQ(ack.covariance_size(), 21);
    EXPECT_EQ(ack.covariance(0), 0);    // x.
    EXPECT_EQ(ack.covariance(5), 5);    // x and the rotation about z.
    EXPECT_EQ(ack.covariance(6), 11);   // y.
    EXPECT_EQ(ack.covariance(20), 55);  // Rotation about z.
    ASSERT_EQ(ack.unobserved_translations_size(), 2);
    EXPECT_EQ(ack.unobserved_translations(1).z(), 0.8);
    ASSERT_EQ(ack.unobserved_rotations_size(), 1);
    EXPECT_EQ(ack.unobserved_rotations(0).z(), 1);
  }
  wire->WritesDone();
  EXPECT_TRUE(ReadAll(*wire).empty());
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, TheFirstMessageMayCarryAScan) {
  auto wire = Open();
  v1::StreamScansRequest request = Scan(1);
  request.set_session(session_);
  wire->Write(request);
  wire->WritesDone();
  EXPECT_EQ(ReadAll(*wire).size(), 1u);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, RepeatedScansAreDuplicatesAndTheStreamGoesOn) {
  auto wire = OpenSession();
  for (const uint64_t sequence : {1, 2, 2, 1, 3}) wire->Write(Scan(sequence));
  wire->WritesDone();
  const std::vector<Response> acks = ReadAll(*wire);
  ASSERT_EQ(acks.size(), 5u);
  EXPECT_EQ(acks[2].outcome(), Response::DUPLICATE);
  EXPECT_EQ(acks[3].outcome(), Response::DUPLICATE);
  EXPECT_FALSE(acks[3].has_timing());
  EXPECT_EQ(acks[4].outcome(), Response::PROCESSED);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, AScanThatCannotBeExpressedIsRejectedWithTheReasonAndUsesItsSequence) {
  auto wire = OpenSession();
  v1::StreamScansRequest no_encoding = Scan(1);
  no_encoding.mutable_scan()->mutable_cloud()->clear_encoding();
  v1::StreamScansRequest bad_type = Scan(2);
  v1::PointField& field = *bad_type.mutable_scan()->mutable_cloud()->add_fields();
  field.set_name("ring");
  field.set_type(static_cast<v1::PointField::Type>(77));
  v1::StreamScansRequest no_cloud = Scan(3);
  no_cloud.mutable_scan()->clear_cloud();
  for (const auto& request : {no_encoding, bad_type, no_cloud, Scan(4)}) wire->Write(request);
  wire->WritesDone();
  const std::vector<Response> acks = ReadAll(*wire);
  ASSERT_EQ(acks.size(), 4u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(acks[i].outcome(), Response::REJECTED) << i;
  EXPECT_THAT(acks[0].reason(), testing::HasSubstr("RAW or QUANTIZED"));
  EXPECT_THAT(acks[1].reason(), testing::HasSubstr("\"ring\""));
  EXPECT_NE(acks[2].reason(), "");
  EXPECT_EQ(acks[3].outcome(), Response::PROCESSED);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, AGapEndsTheStreamAfterWhatCameBeforeIsAcknowledged) {
  auto wire = OpenSession();
  for (const uint64_t sequence : {1, 2, 5}) wire->Write(Scan(sequence));
  EXPECT_EQ(ReadAll(*wire).size(), 2u);
  EXPECT_GRPC_ERROR(wire->Finish(), OUT_OF_RANGE, "3 is expected");
  // The session goes on where it was.
  wire = OpenSession();
  wire->Write(Scan(3));
  wire->WritesDone();
  EXPECT_EQ(ReadAll(*wire).size(), 1u);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, BeginningsThatAreWrong) {
  auto wire = Open();
  wire->WritesDone();
  EXPECT_GRPC_ERROR(wire->Finish(), INVALID_ARGUMENT, "must name its session");
  wire = Open();
  wire->Write(Scan(1));
  EXPECT_GRPC_ERROR(wire->Finish(), INVALID_ARGUMENT, "must name its session");
  wire = Open();
  wire->Write(Hello("nobody-1"));
  EXPECT_GRPC_ERROR(wire->Finish(), NOT_FOUND, "nobody-1");
  wire = OpenSession();
  wire->Write(Hello("bob-1"));
  EXPECT_GRPC_ERROR(wire->Finish(), INVALID_ARGUMENT, "bob-1");
  wire = OpenSession();
  wire->Write(Scan(0));
  EXPECT_GRPC_ERROR(wire->Finish(), INVALID_ARGUMENT, "count from 1");
  EXPECT_EQ(pipeline_.submitted(), 0u);
}

TEST_F(StreamScansTest, AFinishedSessionTakesNoStream) {
  v1::FinishSessionRequest finish;
  finish.set_session(session_);
  v1::Session session;
  EXPECT_GRPC_OK(stubs_->sessions->FinishSession(NewContext().get(), finish, &session));
  auto wire = OpenSession();
  EXPECT_GRPC_ERROR(wire->Finish(), FAILED_PRECONDITION, "finished");
}

TEST_F(StreamScansTest, HalfCloseWaitsForTheAcknowledgementsOfWhatIsQueued) {
  pipeline_.Hold(4);
  auto wire = OpenSession();
  for (uint64_t i = 1; i <= 4; ++i) wire->Write(Scan(i));
  wire->WritesDone();
  pipeline_.WaitForQueued(4);
  pipeline_.Release();
  EXPECT_EQ(ReadAll(*wire).size(), 4u);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, NoMoreScansAreReadThanTheWindowHolds) {
  pipeline_.Hold(1000);
  auto wire = OpenSession();
  for (uint64_t i = 1; i <= 3 * kWindow; ++i) wire->Write(Scan(i));
  pipeline_.WaitForQueued(kWindow);
  // Another call's round trip gives a further scan every chance to come through.
  v1::ListSessionsResponse list;
  EXPECT_GRPC_OK(Merged(stubs_->sessions->ListSessions(NewContext().get(), {}), &list));
  EXPECT_EQ(pipeline_.Waiting(), kWindow);
  pipeline_.Release();
  wire->WritesDone();
  EXPECT_EQ(ReadAll(*wire).size(), 3 * kWindow);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, DurableSequenceMovesBetweenScans) {
  auto wire = OpenSession();
  wire->Write(Scan(1));
  Response ack;
  ASSERT_TRUE(wire->Read(&ack));
  EXPECT_EQ(ack.durable_sequence(), 0u);
  pipeline_.MakeDurable(SessionId(session_), 1);
  ASSERT_TRUE(wire->Read(&ack));
  EXPECT_EQ(ack.sequence(), 0u);
  EXPECT_EQ(ack.outcome(), Response::OUTCOME_UNSPECIFIED);
  EXPECT_EQ(ack.durable_sequence(), 1u);
  wire->WritesDone();
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, ALostLinkLeavesTheSessionToTheNextStream) {
  pipeline_.Hold(2);
  auto lost = OpenSession();
  auto lost_context = std::move(context_);
  // One more than fits: the handler waits inside the pipeline when the link goes.
  for (uint64_t i = 1; i <= 3; ++i) lost->Write(Scan(i));
  pipeline_.WaitForQueued(2);
  lost_context->TryCancel();
  EXPECT_EQ(lost->Finish().error_code(), grpc::StatusCode::CANCELLED);

  pipeline_.Release();
  auto wire = OpenSession();
  for (uint64_t i = 1; i <= 5; ++i) wire->Write(Scan(i));
  wire->WritesDone();
  uint64_t expected = 1;
  for (const Response& ack : ReadAll(*wire)) {
    if (ack.sequence() == 0) continue;
    EXPECT_EQ(ack.sequence(), expected++);
    EXPECT_NE(ack.outcome(), Response::REJECTED);
  }
  EXPECT_EQ(expected, 6u);
  EXPECT_GRPC_OK(wire->Finish());
}

TEST_F(StreamScansTest, ANewerStreamTakesOver) {
  auto older = OpenSession();
  auto older_context = std::move(context_);
  older->Write(Scan(1));
  Response ack;
  ASSERT_TRUE(older->Read(&ack));

  auto newer = OpenSession();
  newer->Write(Scan(2));
  ASSERT_TRUE(newer->Read(&ack));
  EXPECT_EQ(ack.sequence(), 2u);
  EXPECT_FALSE(older->Read(&ack));
  EXPECT_EQ(older->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // The older one's end takes nothing from the newer.
  newer->Write(Scan(3));
  ASSERT_TRUE(newer->Read(&ack));
  EXPECT_EQ(ack.sequence(), 3u);
  newer->WritesDone();
  EXPECT_GRPC_OK(newer->Finish());
}

TEST_F(StreamScansTest, DeletingTheSessionEndsAStreamThatWaitsForAcknowledgements) {
  pipeline_.Hold(4);
  auto wire = OpenSession();
  wire->Write(Scan(1));
  wire->WritesDone();
  pipeline_.WaitForQueued(1);
  v1::DeleteSessionRequest erase;
  erase.set_session(session_);
  v1::DeleteSessionResponse nothing;
  EXPECT_GRPC_OK(stubs_->edits->DeleteSession(NewContext().get(), erase, &nothing));
  EXPECT_EQ(wire->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(StreamScansTest, AClientThatNeverReadsHoldsUpNobodyElse) {
  auto deaf = OpenSession();
  auto deaf_context = std::move(context_);
  // Far more acknowledgements than the connection's flow control window takes.
  std::thread pusher([&] {
    for (uint64_t i = 1; i <= 5000 && deaf->Write(Scan(i)); ++i) {
    }
  });
  const std::string other = stubs_->NewSession("bob");
  auto wire = Open();
  wire->Write(Hello(other));
  for (uint64_t i = 1; i <= 50; ++i) wire->Write(Scan(i));
  wire->WritesDone();
  EXPECT_EQ(ReadAll(*wire).size(), 50u);
  EXPECT_GRPC_OK(wire->Finish());
  deaf_context->TryCancel();
  pusher.join();
  EXPECT_EQ(deaf->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(StreamScansTest, ShutdownAcknowledgesWhatWasReadAndEndsIdleStreams) {
  pipeline_.Hold(4);
  auto wire = OpenSession();
  wire->Write(Scan(1));
  wire->Write(Scan(2));
  pipeline_.WaitForQueued(2);
  std::thread stopper([&] { server_->Shutdown(std::chrono::seconds(15)); });
  pipeline_.Release();
  // Without the grace having to run out: the client below keeps its side open.
  const auto begin = std::chrono::steady_clock::now();
  stopper.join();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  const std::vector<Response> acks = ReadAll(*wire);
  EXPECT_THAT(wire->Finish().error_code(),
              testing::AnyOf(grpc::StatusCode::CANCELLED, grpc::StatusCode::UNAVAILABLE));
  EXPECT_EQ(pipeline_.Waiting(), 0u);
}

}  // namespace
}  // namespace isthmus::rpc
