// The whole server but its disk, over a socket: real odometry, matching and composition. Mistakes
// of robots and readers get an answer that helps, and harm nobody else.
#include <cstring>
#include <limits>

#include "core/io/crc32c.h"
#include "storage/memory_store.h"
#include "tests/server/rpc/room_scans.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {
namespace {

using testing::HasSubstr;
using Response = v1::StreamScansResponse;

class PipelineRpcTest : public testing::Test {
 protected:
  PipelineRpcTest() {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    auto pipeline = server::Pipeline::Open(options, storage::MakeMemoryStore());
    if (!pipeline.ok()) throw std::runtime_error(std::string(pipeline.status().message()));
    pipeline_ = *std::move(pipeline);
    ServerOptions listen;
    listen.listen = "127.0.0.1:0";
    auto server = RpcServer::Start(pipeline_.get(), listen);
    if (!server.ok()) throw std::runtime_error(std::string(server.status().message()));
    server_ = *std::move(server);
    stubs_ = std::make_unique<Stubs>(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
  }

  // Streams the scans and half-closes. Acknowledgements of scans only.
  grpc::Status Stream(const std::string& session,
                      const std::vector<v1::StreamScansRequest>& requests,
                      std::vector<Response>* acks) {
    const auto context = NewContext();
    auto wire = stubs_->sessions->StreamScans(context.get());
    v1::StreamScansRequest hello;
    hello.set_session(session);
    wire->Write(hello);
    for (const auto& request : requests) {
      if (!wire->Write(request)) break;
    }
    wire->WritesDone();
    Response ack;
    while (wire->Read(&ack)) {
      if (ack.sequence() != 0) acks->push_back(ack);
    }
    return wire->Finish();
  }

  // Drives a robot through the room and finishes its session.
  std::string Drive(const std::string& robot, uint64_t scans) {
    const std::string session = stubs_->NewSession(robot);
    std::vector<v1::StreamScansRequest> requests;
    for (uint64_t i = 1; i <= scans; ++i) requests.push_back(RoomScan("", i));
    std::vector<Response> acks;
    EXPECT_GRPC_OK(Stream(session, requests, &acks));
    EXPECT_EQ(acks.size(), scans);
    v1::FinishSessionRequest finish;
    finish.set_session(session);
    v1::Session finished;
    EXPECT_GRPC_OK(stubs_->sessions->FinishSession(NewContext().get(), finish, &finished));
    pipeline_->WaitUntilIdle();
    return session;
  }

  v1::Session Get(const std::string& session) {
    v1::GetSessionRequest request;
    request.set_session(session);
    v1::Session response;
    EXPECT_GRPC_OK(stubs_->sessions->GetSession(NewContext().get(), request, &response));
    return response;
  }

  grpc::Status Upload(const std::string& session, uint32_t index, const std::vector<float>& xyz) {
    v1::UploadSubmapRequest part;
    v1::UploadSubmapHeader& header = *part.mutable_header();
    header.set_session(session);
    header.set_index(index);
    header.set_size(xyz.size() * sizeof(float));
    header.set_crc32c(io::Crc32c(xyz.data(), header.size()));
    v1::PointCloud& cloud = *header.mutable_cloud();
    cloud.set_encoding(v1::PointCloud::RAW);
    cloud.set_width(static_cast<uint32_t>(xyz.size() / 3));
    cloud.set_stride(12);
    const char* const names[] = {"x", "y", "z"};
    for (uint32_t i = 0; i < 3; ++i) {
      v1::PointField& field = *cloud.add_fields();
      field.set_name(names[i]);
      field.set_offset(4 * i);
      field.set_type(v1::PointField::FLOAT32);
    }
    const auto context = NewContext();
    v1::UploadSubmapResponse response;
    auto writer = stubs_->sessions->UploadSubmap(context.get(), &response);
    writer->Write(part);
    part.mutable_chunk()->set_data(xyz.data(), xyz.size() * sizeof(float));
    writer->Write(part);
    writer->WritesDone();
    return writer->Finish();
  }

  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<RpcServer> server_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(PipelineRpcTest, ADriveBecomesAMapThatCanBeRead) {
  const std::string session = Drive("alice", 30);
  const v1::Session finished = Get(session);
  EXPECT_EQ(finished.quantized_version(), 2u);  // The version for scans that the server reads.
  EXPECT_EQ(finished.state(), v1::Session::FINISHED);
  EXPECT_EQ(finished.last_sequence(), 30u);
  EXPECT_EQ(finished.durable_sequence(), 30u);
  EXPECT_EQ(finished.scans_processed(), 30u);
  EXPECT_NEAR(finished.travelled_m(), 29 * 0.2, 0.2);
  EXPECT_GT(finished.odometry_ms_mean(), 0);
  EXPECT_GE(finished.submap_count(), 1u);
  EXPECT_TRUE(finished.has_component());

  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));
  EXPECT_TRUE(info.settled());
  EXPECT_GT(info.revision(), 0);
  ASSERT_EQ(info.components_size(), 1);
  EXPECT_GT(info.components(0).point_count(), 1000u);

  v1::GetTrajectoryRequest request;
  request.set_robot("alice");
  request.set_frame(v1::MAP);
  const auto context = NewContext();
  auto reader = stubs_->map->GetTrajectory(context.get(), request);
  v1::GetTrajectoryResponse trajectory;
  ASSERT_TRUE(reader->Read(&trajectory));
  ASSERT_EQ(trajectory.poses_size(), 30);
  EXPECT_EQ(trajectory.poses(29).stamp_ns(), 3'000'000'000);
  EXPECT_NEAR(trajectory.poses(29).pose().translation().x(), 29 * 0.2, 0.1);
  EXPECT_FALSE(reader->Read(&trajectory));
  EXPECT_GRPC_OK(reader->Finish());
}

TEST_F(PipelineRpcTest, TheMapIsQueriedAndExported) {
  Drive("alice", 20);
  auto context = NewContext();
  v1::QueryRegionRequest query;
  query.mutable_sphere()->set_radius_m(6.5);
  auto points = stubs_->map->QueryRegion(context.get(), query);
  v1::QueryRegionResponse part;
  uint64_t found = 0;
  while (points->Read(&part)) {
    const std::string& data = part.cloud().data();
    for (size_t i = 0; i + 20 <= data.size(); i += 20, ++found) {
      float xyz[3];
      std::memcpy(xyz, data.data() + i, sizeof(xyz));
      EXPECT_LE(Eigen::Vector3f(xyz[0], xyz[1], xyz[2]).norm(), 6.5F + 1e-3F);
    }
  }
  EXPECT_GRPC_OK(points->Finish());
  EXPECT_GT(found, 500u);

  for (const auto& [format, magic] :
       {std::pair(v1::ExportMapRequest::PCD_ASCII, "# .PCD"),
        std::pair(v1::ExportMapRequest::PCD_BINARY, "# .PCD"),
        std::pair(v1::ExportMapRequest::PCD_BINARY_COMPRESSED, "# .PCD"),
        std::pair(v1::ExportMapRequest::PLY, "ply"),
        std::pair(v1::ExportMapRequest::OCTOMAP_BINARY, "# Octomap OcTree binary file"),
        std::pair(v1::ExportMapRequest::OCTOMAP_FULL, "# Octomap OcTree file")}) {
    v1::ExportMapRequest request;
    request.set_format(format);
    context = NewContext();
    auto reader = stubs_->map->ExportMap(context.get(), request);
    v1::ExportMapResponse response;
    std::string file;
    while (reader->Read(&response)) file += response.data();
    EXPECT_GRPC_OK(reader->Finish());
    EXPECT_THAT(file.substr(0, 60), testing::StartsWith(magic));
    EXPECT_EQ(response.size(), file.size());
    EXPECT_EQ(response.crc32c(), io::Crc32c(file.data(), file.size()));

    request.set_component(7);
    context = NewContext();
    reader = stubs_->map->ExportMap(context.get(), request);
    EXPECT_FALSE(reader->Read(&response));
    EXPECT_GRPC_ERROR(reader->Finish(), NOT_FOUND, "no map 7");
  }
}

// A cloud made of the good one by a change to its points or its description.
v1::StreamScansRequest Bad(uint64_t sequence,
                           const std::function<void(v1::PointCloud&, std::vector<float>&)>& spoil) {
  v1::StreamScansRequest request = RoomScan("", sequence);
  v1::PointCloud& cloud = *request.mutable_scan()->mutable_cloud();
  std::vector<float> values(cloud.data().size() / sizeof(float));
  std::memcpy(values.data(), cloud.data().data(), cloud.data().size());
  spoil(cloud, values);
  cloud.set_data(values.data(), values.size() * sizeof(float));
  return request;
}

TEST_F(PipelineRpcTest, BadScansAreRejectedWithAReasonAndTheSessionGoesOn) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const auto fill = [](float value) {  // Every coordinate.
    return [value](v1::PointCloud&, std::vector<float>& values) {
      for (size_t i = 0; i < values.size(); i += 6) std::fill_n(&values[i], 3, value);
    };
  };
  std::vector<v1::StreamScansRequest> requests;
  for (uint64_t i = 1; i <= 5; ++i) requests.push_back(RoomScan("", i));
  requests.push_back(Bad(6, [](v1::PointCloud& cloud, std::vector<float>& values) {
    cloud.set_width(0);
    values.clear();
  }));
  requests.push_back(Bad(7, fill(kNaN)));
  requests.push_back(Bad(8, fill(kInf)));
  requests.push_back(Bad(9, fill(0)));   // No returns.
  requests.push_back(Bad(10, fill(3)));  // All in one place.
  requests.push_back(Bad(11, [](v1::PointCloud& cloud, std::vector<float>&) {
    cloud.mutable_fields(2)->set_name("height");
  }));
  requests.push_back(Bad(
      12, [](v1::PointCloud& cloud, std::vector<float>&) { cloud.set_width(cloud.width() + 1); }));
  requests.push_back(Bad(13, [](v1::PointCloud& cloud, std::vector<float>&) {
    cloud.set_encoding(v1::PointCloud::QUANTIZED);
  }));
  requests.push_back(Bad(14, [](v1::PointCloud& cloud, std::vector<float>&) {
    cloud.mutable_fields(1)->set_offset(1000);
  }));
  // Some points are bad, the others are used. The robot stood still in the meantime.
  requests.push_back(Bad(15, [&](v1::PointCloud& cloud, std::vector<float>& values) {
    const std::string seen = RoomCloud(RoomPose(6), RoomPose(6)).data();
    std::memcpy(values.data(), seen.data(), seen.size());
    for (size_t i = 0; i < values.size(); i += 600) values[i] = kNaN;  // Each is an x.
    (void)cloud;
  }));
  const std::string session = stubs_->NewSession("alice");
  std::vector<Response> acks;
  EXPECT_GRPC_OK(Stream(session, requests, &acks));
  ASSERT_EQ(acks.size(), 15u);
  for (const Response& ack : acks) {
    const bool bad = ack.sequence() >= 6 && ack.sequence() <= 14;
    EXPECT_EQ(ack.outcome(), bad ? Response::REJECTED : Response::PROCESSED)
        << ack.sequence() << ": " << ack.reason();
    EXPECT_EQ(ack.reason().empty(), !bad) << ack.sequence();
  }
  EXPECT_THAT(acks[5].reason(), HasSubstr("empty"));
  EXPECT_THAT(acks[10].reason(), HasSubstr("z"));
  const v1::Session status = Get(session);
  EXPECT_EQ(status.scans_processed(), 6u);
  EXPECT_EQ(status.scans_rejected(), 9u);
  // Another robot was not touched.
  Drive("bob", 5);
}

TEST_F(PipelineRpcTest, SessionsThatCannotBeOpened) {
  v1::CreateSessionRequest request;
  v1::Session session;
  request.set_robot("alice");
  request.set_sensor("vlp17");
  EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(NewContext().get(), request, &session),
                    INVALID_ARGUMENT, "vlp16");
  request.set_sensor("vlp16");
  for (const std::string& name : {std::string(), std::string(65, 'a'), std::string("a/b")}) {
    request.set_robot(name);
    EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(NewContext().get(), request, &session),
                      INVALID_ARGUMENT, "robot name");
  }
}

TEST_F(PipelineRpcTest, AGapInTheSequenceNamesTheOneExpected) {
  const std::string session = stubs_->NewSession("alice");
  std::vector<Response> acks;
  EXPECT_GRPC_ERROR(Stream(session, {RoomScan("", 1), RoomScan("", 3)}, &acks), OUT_OF_RANGE,
                    "2 is expected");
  EXPECT_EQ(acks.size(), 1u);
  EXPECT_GRPC_OK(Stream(session, {RoomScan("", 2)}, &acks));
  EXPECT_EQ(acks.size(), 2u);
}

TEST_F(PipelineRpcTest, UploadedSubmapsKeepTheirOrderAndContent) {
  const std::string session = stubs_->NewSession("carol");
  const std::vector<float> xyz = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_GRPC_ERROR(Upload(session, 1, xyz), OUT_OF_RANGE, "0");
  EXPECT_GRPC_OK(Upload(session, 0, xyz));
  EXPECT_GRPC_OK(Upload(session, 0, xyz));
  EXPECT_GRPC_ERROR(Upload(session, 0, {1, 2, 3}), ALREADY_EXISTS, "");
  EXPECT_GRPC_OK(Upload(session, 1, xyz));
  EXPECT_EQ(Get(session).submap_count(), 2u);

  std::vector<Response> acks;
  EXPECT_GRPC_ERROR(Stream(session, {RoomScan("", 1)}, &acks), FAILED_PRECONDITION,
                    "uploaded submaps");
  const std::string scans = Drive("alice", 3);
  EXPECT_GRPC_ERROR(Upload(scans, 0, xyz), FAILED_PRECONDITION, "");
}

TEST_F(PipelineRpcTest, RobotsWithoutACommonMapHaveNoTransform) {
  Drive("alice", 3);
  v1::GetTransformRequest request;
  request.set_robot_a("alice");
  request.set_robot_b("nobody");
  v1::GetTransformResponse response;
  EXPECT_GRPC_ERROR(stubs_->map->GetTransform(NewContext().get(), request, &response), NOT_FOUND,
                    "nobody");
  EXPECT_GRPC_OK(Upload(stubs_->NewSession("carol"), 0, {1, 2, 3, 4, 5, 6}));
  request.set_robot_b("carol");
  EXPECT_GRPC_ERROR(stubs_->map->GetTransform(NewContext().get(), request, &response),
                    FAILED_PRECONDITION, "alice and carol");
}

TEST_F(PipelineRpcTest, ADeletedSessionLeavesTheMap) {
  const std::string session = Drive("alice", 5);
  v1::DeleteSessionRequest erase;
  erase.set_session(session);
  v1::DeleteSessionResponse nothing;
  EXPECT_GRPC_OK(stubs_->edits->DeleteSession(NewContext().get(), erase, &nothing));
  pipeline_->WaitUntilIdle();
  v1::ListSubmapsResponse submaps;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListSubmaps(NewContext().get(), {}), &submaps));
  EXPECT_EQ(submaps.submaps_size(), 0);
  v1::GetSessionRequest get;
  get.set_session(session);
  v1::Session gone;
  EXPECT_GRPC_ERROR(stubs_->sessions->GetSession(NewContext().get(), get, &gone), NOT_FOUND,
                    session);
}

TEST_F(PipelineRpcTest, ASessionThatKeepsTheNewestSkipsInOrderAndCounts) {
  v1::CreateSessionRequest create;
  create.set_robot("hasty");
  create.set_sensor("vlp16");
  create.set_when_behind(v1::WHEN_BEHIND_KEEP_NEWEST);
  v1::Session session;
  ASSERT_GRPC_OK(stubs_->sessions->CreateSession(NewContext().get(), create, &session));
  EXPECT_EQ(session.when_behind(), v1::WHEN_BEHIND_KEEP_NEWEST);
  // Many times faster than the odometry.
  constexpr uint64_t kScans = 60;
  std::vector<v1::StreamScansRequest> requests;
  for (uint64_t i = 1; i <= kScans; ++i) requests.push_back(RoomScan("", i));
  std::vector<Response> acks;
  EXPECT_GRPC_OK(Stream(session.id(), requests, &acks));
  ASSERT_EQ(acks.size(), kScans);
  uint64_t skipped = 0;
  for (uint64_t i = 0; i < kScans; ++i) {
    EXPECT_EQ(acks[i].sequence(), i + 1);
    const bool is_skipped = acks[i].outcome() == Response::SKIPPED;
    skipped += is_skipped ? 1 : 0;
    EXPECT_EQ(acks[i].has_t_odom_sensor(), !is_skipped);
    const auto used = is_skipped ? Response::SKIPPED : Response::PROCESSED;
    EXPECT_EQ(acks[i].outcome(), used) << acks[i].reason();
  }
  EXPECT_EQ(acks.back().outcome(), Response::PROCESSED) << "the newest";
  EXPECT_GT(skipped, 0u);
  EXPECT_EQ(Get(session.id()).scan_counts().skipped(), skipped);
  create.set_when_behind(static_cast<v1::WhenBehind>(7));
  EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(NewContext().get(), create, &session),
                    INVALID_ARGUMENT, "when_behind");
}

}  // namespace
}  // namespace isthmus::rpc
