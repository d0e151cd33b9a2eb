// Localisation over a socket: a robot is followed in the map that another one made.
#include <absl/status/status.h>

#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "storage/memory_store.h"
#include "tests/server/rpc/room_scans.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {
namespace {

using State = v1::LocaliseResponse;

class LocaliseRpcTest : public testing::Test {
 protected:
  LocaliseRpcTest() {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    pipeline_ = *server::Pipeline::Open(options, storage::MakeMemoryStore());
    ServerOptions listen;
    listen.listen = "127.0.0.1:0";
    server_ = *RpcServer::Start(pipeline_.get(), listen);
    const auto channel =
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
    stubs_ = std::make_unique<Stubs>(channel);
    localisation_ = v1::LocalisationService::NewStub(channel);
  }

  void MakeMap(uint64_t scans) {
    const std::string session = stubs_->NewSession("alice");
    const auto context = NewContext();
    auto wire = stubs_->sessions->StreamScans(context.get());
    for (uint64_t i = 1; i <= scans; ++i) wire->Write(RoomScan(session, i));
    wire->WritesDone();
    v1::StreamScansResponse ack;
    while (wire->Read(&ack)) {
    }
    EXPECT_GRPC_OK(wire->Finish());
    v1::FinishSessionRequest finish;
    finish.set_session(session);
    v1::Session finished;
    EXPECT_GRPC_OK(stubs_->sessions->FinishSession(NewContext().get(), finish, &finished));
    pipeline_->WaitUntilIdle();
  }

  static v1::LocaliseRequest First(const std::string& sensor = "vlp16") {
    v1::LocaliseRequest request;
    request.mutable_begin()->set_sensor(sensor);
    return request;
  }
  static v1::LocaliseRequest Scan(uint64_t sequence) {
    v1::LocaliseRequest request;
    *request.mutable_scan() = RoomScan("", sequence).scan();
    return request;
  }
  // Sends all, half-closes, and reads the answers.
  grpc::Status Localise(const std::vector<v1::LocaliseRequest>& requests,
                        std::vector<v1::LocaliseResponse>* answers) {
    const auto context = NewContext();
    auto wire = localisation_->Localise(context.get());
    for (const auto& request : requests) {
      if (!wire->Write(request)) break;
    }
    wire->WritesDone();
    v1::LocaliseResponse answer;
    while (wire->Read(&answer)) answers->push_back(answer);
    return wire->Finish();
  }

  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<RpcServer> server_;
  std::unique_ptr<Stubs> stubs_;
  std::unique_ptr<v1::LocalisationService::Stub> localisation_;
};

TEST_F(LocaliseRpcTest, ARobotIsFoundAndTheMapDoesNotGrow) {
  MakeMap(40);
  const MapInfo before = pipeline_->GetMapInfo();
  std::vector<v1::LocaliseRequest> requests = {First()};
  for (uint64_t i = 12; i < 40; ++i) requests.push_back(Scan(i));
  std::vector<v1::LocaliseResponse> answers;
  ASSERT_GRPC_OK(Localise(requests, &answers));
  ASSERT_EQ(answers.size(), 28u);
  int located = 0;
  for (size_t k = 0; k < answers.size(); ++k) {
    const v1::LocaliseResponse& answer = answers[k];
    EXPECT_EQ(answer.sequence(), 12 + k) << "one answer each, in order";
    EXPECT_EQ(answer.rejected(), "");
    if (answer.state() != State::LOCATED) continue;
    ++located;
    // The map's frame is the first scan's.
    const Pose truth = RoomPose(1).Inverse() * RoomPose(answer.sequence());
    const v1::Vector3& at = answer.t_map_sensor().translation();
    EXPECT_LT((Eigen::Vector3d(at.x(), at.y(), at.z()) - truth.translation()).norm(), 0.1);
    EXPECT_EQ(answer.covariance_size(), 21);
    EXPECT_TRUE(answer.has_t_map_odom());
  }
  EXPECT_GT(located, 10);
  pipeline_->WaitUntilIdle();
  const MapInfo after = pipeline_->GetMapInfo();
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(pipeline_->sessions().List().size(), 1u);
}

TEST_F(LocaliseRpcTest, WhatIsAskedWronglyIsAnswered) {
  std::vector<v1::LocaliseResponse> answers;
  EXPECT_GRPC_ERROR(Localise({First()}, &answers), FAILED_PRECONDITION, "no map");
  MakeMap(20);
  EXPECT_GRPC_ERROR(Localise({Scan(1)}, &answers), INVALID_ARGUMENT, "begin");
  EXPECT_GRPC_ERROR(Localise({First(), First()}, &answers), INVALID_ARGUMENT, "only the first");
  EXPECT_GRPC_ERROR(Localise({First("sonar")}, &answers), INVALID_ARGUMENT, "vlp16");
  v1::LocaliseRequest elsewhere = First();
  elsewhere.mutable_begin()->set_in_map_of("nobody");
  EXPECT_GRPC_ERROR(Localise({elsewhere}, &answers), NOT_FOUND, "nobody");
  v1::LocaliseRequest bent = First();
  v1::LocaliseRequest nameless = First();
  nameless.mutable_begin()->set_robot("a b");
  EXPECT_GRPC_ERROR(Localise({nameless}, &answers), INVALID_ARGUMENT, "robot name \"a b\"");
  bent.mutable_begin()->mutable_t_base_sensor()->mutable_translation()->set_x(1e300);
  EXPECT_GRPC_ERROR(Localise({bent}, &answers), INVALID_ARGUMENT, "t_base_sensor");
  EXPECT_TRUE(answers.empty());
}

TEST_F(LocaliseRpcTest, ARobotIsShownWhileItIsLocalised) {
  MakeMap(40);
  const auto context = NewContext();
  auto wire = localisation_->Localise(context.get());
  v1::LocaliseRequest first = First();
  first.mutable_begin()->set_robot("bob");
  ASSERT_TRUE(wire->Write(first));
  v1::LocaliseRequest useless = Scan(11);
  useless.mutable_scan()->mutable_cloud()->clear_data();
  ASSERT_TRUE(wire->Write(useless));
  v1::LocaliseResponse answer;
  ASSERT_TRUE(wire->Read(&answer));
  for (uint64_t i = 12; answer.state() != State::LOCATED; ++i) {
    ASSERT_LT(i, 40u) << "never located";
    ASSERT_TRUE(wire->Write(Scan(i)));
    ASSERT_TRUE(wire->Read(&answer));
  }
  v1::ServerStatus status;
  ASSERT_GRPC_OK(stubs_->admin->GetStatus(NewContext().get(), {}, &status));
  EXPECT_EQ(status.sessions_size(), 0);
  ASSERT_EQ(status.localising_size(), 1);
  const v1::RobotPlace& place = status.localising(0);
  EXPECT_EQ(place.robot(), "bob");
  EXPECT_EQ(place.session(), "");
  EXPECT_EQ(place.component(), 0u);
  EXPECT_EQ(place.t_map_sensor().translation().x(), answer.t_map_sensor().translation().x());
  EXPECT_EQ(place.lag_ms(), 0);
  EXPECT_EQ(place.localising().state(), State::LOCATED);
  EXPECT_EQ(place.localising().scans(), answer.sequence() - 10);
  EXPECT_EQ(place.localising().rejected(), 1u);
  EXPECT_GT(place.localising().since_ns(), 0);
  EXPECT_GE(place.localising().received_ns(), place.localising().since_ns());
  const std::vector<RobotPlace> watched = pipeline_->RobotPlaces();
  ASSERT_EQ(watched.size(), 1u);
  EXPECT_EQ(watched[0].robot, RobotId("bob"));

  wire->WritesDone();
  EXPECT_FALSE(wire->Read(&answer));
  EXPECT_GRPC_OK(wire->Finish());
  EXPECT_THAT(pipeline_->RobotPlaces(), testing::IsEmpty());
  pipeline_->WaitUntilIdle();
  const auto events = pipeline_->events().List({.robot = RobotId("bob")});
  ASSERT_TRUE(events.ok());
  ASSERT_EQ(events->events.size(), 2u);
  EXPECT_EQ(events->events[0].kind, EventKind::kLocalisingBegun);
  EXPECT_EQ(events->events[0].text, "bob is localised in the largest map");
  EXPECT_EQ(events->events[1].kind, EventKind::kLocalisingEnded);
  EXPECT_THAT(events->events[1].text, testing::HasSubstr("its place was known at 1 of"));
}

TEST_F(LocaliseRpcTest, AScanThatCannotBeUsedIsOneAnswerAndTheStreamGoesOn) {
  MakeMap(20);
  v1::LocaliseRequest empty = Scan(5);
  empty.mutable_scan()->mutable_cloud()->clear_data();
  v1::LocaliseRequest past = Scan(4);  // Before the one that was used.
  std::vector<v1::LocaliseResponse> answers;
  ASSERT_GRPC_OK(Localise({First(), empty, Scan(6), past, Scan(7)}, &answers));
  ASSERT_EQ(answers.size(), 4u);
  EXPECT_NE(answers[0].rejected(), "");
  EXPECT_EQ(answers[1].rejected(), "");
  EXPECT_NE(answers[2].rejected(), "");
  EXPECT_EQ(answers[3].rejected(), "");
}

TEST_F(LocaliseRpcTest, AServerThatStopsEndsTheStreams) {
  MakeMap(20);
  const auto context = NewContext();
  auto wire = localisation_->Localise(context.get());
  ASSERT_TRUE(wire->Write(First()));
  ASSERT_TRUE(wire->Write(Scan(5)));
  v1::LocaliseResponse answer;
  ASSERT_TRUE(wire->Read(&answer));
  server_->Shutdown(std::chrono::seconds(15));
  EXPECT_FALSE(wire->Read(&answer));
  EXPECT_FALSE(wire->Finish().ok());
}

}  // namespace
}  // namespace isthmus::rpc
