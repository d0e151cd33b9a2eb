// `isthmus top` and what `isthmus status` says of the server itself, against a server over a
// socket.
#include <gmock/gmock.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/rpc/server.h"
#include "tests/client/cli/program.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class TopTest : public testing::Test {
 protected:
  void SetUp() override {
    SessionLoad alice;
    alice.session = SessionId("alice-1");
    alice.robot = RobotId("alice");
    alice.tracking = Tracking::kOk;
    alice.waiting_scans = 4;
    alice.received_sequence = 30;
    alice.acknowledged_sequence = 28;
    alice.durable_sequence = 20;
    alice.oldest_unacknowledged_ns = 9'500'000'000;
    alice.oldest_undurable_ns = 8'000'000'000;
    {
      MutexLock lock(&pipeline_.load_mutex);
      pipeline_.load.now_ns = 10'000'000'000;
      pipeline_.load.sessions = {alice};
      pipeline_.load.disk = {1'000'000, 0, 0, 0, 50'000'000'000, 90'000'000'000};
    }
    rpc::ServerOptions options;
    options.listen = "127.0.0.1:0";
    auto server = rpc::RpcServer::Start(&pipeline_, options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  ProgramResult Ask(const std::string& command) const {
    return Isthmus(command + " --server " + server_->address());
  }

  rpc::FakePipeline pipeline_;
  std::unique_ptr<rpc::RpcServer> server_;
};

TEST_F(TopTest, ViewSaysWhereBrowsersFindTheServer) {
  const ProgramResult none = Ask("view --print");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("web.listen"));
  server_->TellWebAddress("http://127.0.0.1:8080");
  EXPECT_EQ(Ask("view --print").out, "http://127.0.0.1:8080\n");
  EXPECT_THAT(Ask("status").out, HasSubstr("web          http://127.0.0.1:8080\n"));
  // A server that listens at all its addresses is shown with the one that is known here.
  server_->TellWebAddress("https://0.0.0.0:8443");
  EXPECT_EQ(Ask("view --print").out, "https://127.0.0.1:8443\n");
  EXPECT_EQ(json::parse(Ask("status --json").out)["server"]["web_address"], "https://0.0.0.0:8443");
}

TEST_F(TopTest, PrintsFramesWhereThereIsNoTerminal) {
  const ProgramResult result = Ask("top -n 2 --interval 0.1");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("site default   up 00:00:0"));
  EXPECT_THAT(result.out, HasSubstr("alice-1  ok"));
  EXPECT_THAT(result.out, HasSubstr("2, 0.5 s"));
  EXPECT_THAT(result.out, HasSubstr("10, 2.0 s"));
  EXPECT_THAT(result.out, Not(HasSubstr("\x1b")));
  const size_t first = result.out.find("SESSION");
  EXPECT_NE(result.out.find("SESSION", first + 1), std::string::npos) << "two frames";
  EXPECT_EQ(Ask("top -n 0").code, 2);
  EXPECT_EQ(Ask("top --interval 0").code, 2);
  EXPECT_EQ(Isthmus("top -n 1 --server localhost:1").code, 4);
}

TEST_F(TopTest, StatusSaysWhereEachRobotIsAndWhatIsDegraded) {
  {
    MutexLock lock(&pipeline_.load_mutex);
    pipeline_.load.storage_problem = "the disk is full\x1b[2J";
  }
  const ProgramResult status = Ask("status");
  ASSERT_EQ(status.code, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("\nversion      "));
  EXPECT_THAT(status.out, HasSubstr("disk         1.0 MB used by the map, 50.0 GB free"));
  EXPECT_THAT(status.out, HasSubstr("lag          alice-1: not acknowledged 2 scans, 0.5 s; "
                                    "not durable 10 scans, 2.0 s; queue 4"));
  EXPECT_THAT(status.out,
              HasSubstr("DEGRADED     isthmus.v1.SessionService: the disk is full\\x1b[2J"));
  const json document = json::parse(Ask("status --json").out)["server"];
  EXPECT_EQ(document["disk"]["free_bytes"], 50'000'000'000);
  EXPECT_EQ(document["sessions"][0]["tracking"], "TRACKING_OK");
  EXPECT_EQ(document["degraded"].size(), 2u);
  EXPECT_GT(document["process"]["resident_bytes"], 0);
}

// A server of before there was a status: it has neither AdminService nor what that says.
class OldMaps final : public v1::MapService::Service {
 public:
  grpc::Status GetMapInfo(grpc::ServerContext*, const v1::GetMapInfoRequest*,
                          v1::MapInfo* info) override {
    info->set_revision(17);
    return grpc::Status::OK;
  }
  grpc::Status ListLoops(grpc::ServerContext*, const v1::ListLoopsRequest*,
                         grpc::ServerWriter<v1::ListLoopsResponse>*) override {
    return grpc::Status::OK;
  }
};
class OldSessions final : public v1::SessionService::Service {
 public:
  grpc::Status ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest*,
                            grpc::ServerWriter<v1::ListSessionsResponse>*) override {
    return grpc::Status::OK;
  }
};

TEST(OldServer, StatusSaysTheRestAndTopSaysWhy) {
  OldMaps maps;
  OldSessions sessions;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&maps);
  builder.RegisterService(&sessions);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  const std::string at = " --server 127.0.0.1:" + std::to_string(port);
  const ProgramResult status = Isthmus("status" + at);
  EXPECT_EQ(status.code, 0) << status.err;
  EXPECT_THAT(status.out, HasSubstr("revision     17"));
  EXPECT_THAT(status.out, Not(HasSubstr("version")));
  const ProgramResult as_json = Isthmus("status --json" + at);
  EXPECT_EQ(as_json.code, 0) << as_json.err;
  EXPECT_FALSE(json::parse(as_json.out).contains("server"));
  const ProgramResult top = Isthmus("top -n 1" + at);
  EXPECT_EQ(top.code, 1);
  EXPECT_THAT(top.err, HasSubstr("too old"));
}

}  // namespace
}  // namespace isthmus::cli
