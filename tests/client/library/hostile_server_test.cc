// The client against a server that says what no sound one says: it ends, and keeps its memory.
#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include "client/library/client.h"
#include "core/codec/payload_builder.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "tests/client/library/fake_server.h"

namespace isthmus::client {
namespace {

using testing::HasSubstr;

// Answers without end, to whoever reads on.
class EndlessMap final : public v1::MapService::Service {
 public:
  grpc::Status GetMapInfo(grpc::ServerContext*, const v1::GetMapInfoRequest*,
                          v1::MapInfo*) override {
    return grpc::Status::OK;
  }
  grpc::Status ListSubmaps(grpc::ServerContext*, const v1::ListSubmapsRequest*,
                           grpc::ServerWriter<v1::ListSubmapsResponse>* writer) override {
    v1::ListSubmapsResponse part;
    for (int i = 0; i < 1000; ++i) part.add_submaps()->set_session(std::string(100, 's'));
    return WriteOn(part, writer);
  }
  grpc::Status WatchMap(grpc::ServerContext*, const v1::WatchMapRequest*,
                        grpc::ServerWriter<v1::WatchMapResponse>* writer) override {
    v1::WatchMapResponse part;
    for (int i = 0; i < 10'000; ++i) part.add_tiles()->set_version(1u << 30);
    part.set_more(true);
    return WriteOn(part, writer);
  }
  grpc::Status ExportMap(grpc::ServerContext*, const v1::ExportMapRequest*,
                         grpc::ServerWriter<v1::ExportMapResponse>* writer) override {
    v1::ExportMapResponse part;
    part.set_data(std::string(100'000, 'm'));
    return WriteOn(part, writer);
  }
  grpc::Status QueryRegion(grpc::ServerContext*, const v1::QueryRegionRequest*,
                           grpc::ServerWriter<v1::QueryRegionResponse>* writer) override {
    v1::QueryRegionResponse part;
    part.add_robots(std::string(100'000, 'r'));
    return WriteOn(part, writer);
  }

  std::atomic<uint64_t> sent{0};

 private:
  template <typename Response>
  grpc::Status WriteOn(const Response& part, grpc::ServerWriter<Response>* writer) {
    while (writer->Write(part)) sent += part.ByteSizeLong();
    return grpc::Status::OK;
  }
};

// Sends more than it announced.
class LyingAdmin final : public v1::AdminService::Service {
 public:
  grpc::Status BackUp(grpc::ServerContext*, const v1::BackUpRequest*,
                      grpc::ServerWriter<v1::BackUpResponse>* writer) override {
    v1::BackUpResponse part;
    part.set_copied(1);
    part.set_total_bytes(announced);
    part.set_data(std::string(100'000, 'b'));
    while (writer->Write(part)) {
    }
    return grpc::Status::OK;
  }

  std::atomic<uint64_t> announced{250'000};
};

class HostileServerTest : public testing::Test {
 protected:
  HostileServerTest() {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&map_);
    builder.RegisterService(&admin_);
    server_ = builder.BuildAndStart();
    ClientOptions options;
    options.address = "127.0.0.1:" + std::to_string(port);
    options.sleep = [](double) {};
    options.max_answer_bytes = options.max_file_bytes = kMost;
    client_ = *Client::Connect(options);
    folder_ = std::filesystem::path(testing::TempDir()) / "isthmus_hostile_server" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~HostileServerTest() override {
    std::filesystem::remove_all(folder_);
    client_.reset();
    server_->Shutdown(std::chrono::system_clock::now());
  }

  static constexpr uint64_t kMost = 1'000'000;
  EndlessMap map_;
  LyingAdmin admin_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Client> client_;
  std::filesystem::path folder_;
};

TEST_F(HostileServerTest, EndlessListsAndStepsAreRefused) {
  const absl::Status list = client_->ListSubmaps().status();
  EXPECT_EQ(list.code(), absl::StatusCode::kResourceExhausted) << list;
  EXPECT_THAT(std::string(list.message()), HasSubstr("1000000"));
  const absl::Status step = client_->WatchMap({}, 0, [](const MapStep&) { return true; });
  EXPECT_EQ(step.code(), absl::StatusCode::kResourceExhausted) << step;
}

TEST_F(HostileServerTest, EndlessFilesAreRefusedAndLeaveNothing) {
  const std::string path = folder_ / "merged.pcd";
  const absl::Status file = client_->ExportToFile({}, path).status();
  EXPECT_EQ(file.code(), absl::StatusCode::kResourceExhausted) << file;
  uint64_t read = 0;
  const absl::Status query = client_->QueryRegion({}, [&](const RegionChunk&) {
    ++read;
    return true;
  });
  EXPECT_EQ(query.code(), absl::StatusCode::kResourceExhausted) << query;
  EXPECT_LE(read, kMost / 100'000);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(HostileServerTest, ABackupIsAsLongAsAnnouncedAndFitsTheDisk) {
  const std::string folder = folder_ / "copy";
  const absl::Status longer = client_->BackUp(folder).status();
  EXPECT_EQ(longer.code(), absl::StatusCode::kOutOfRange) << longer;
  admin_.announced = std::numeric_limits<uint64_t>::max();
  const absl::Status larger = client_->BackUp(folder).status();
  EXPECT_EQ(larger.code(), absl::StatusCode::kResourceExhausted) << larger;
  EXPECT_THAT(std::string(larger.message()), HasSubstr("has room for"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST(HostileSessions, MoreScansThanAnySessionHasAreRefused) {
  FakeServer server;
  ClientOptions options;
  options.address = server.address();
  options.sleep = [](double) {};
  const auto client = Client::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  server.sessions.taken_up = std::numeric_limits<uint64_t>::max();
  ASSERT_TRUE((*client)->GetSession(SessionId("alice-1")).ok()) << "it lies from now on";
  const absl::Status opened = (*client)->OpenScanStream(SessionId("alice-1")).status();
  EXPECT_EQ(opened.code(), absl::StatusCode::kDataLoss) << opened;

  // Between two questions of a stream, too.
  FakeServer turned;
  options.address = turned.address();
  const auto other = Client::Connect(options);
  auto stream = (*other)->OpenScanStream(SessionId("alice-1"));
  ASSERT_TRUE(stream.ok()) << stream.status();
  turned.sessions.others_at_break = std::numeric_limits<uint64_t>::max();
  turned.sessions.break_after = 1;
  const PointPayload payload = codec::MakePayload(Cloud{{1, 2, 3, 4}});
  (void)(*stream)->Push(1'000'000'000, payload);
  const absl::Status finished = (*stream)->Finish();
  EXPECT_EQ(finished.code(), absl::StatusCode::kDataLoss) << finished;
}

}  // namespace
}  // namespace isthmus::client
