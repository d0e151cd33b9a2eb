// Health checking over a socket: the services that serve.
#include "tests/server/rpc/health_watcher.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

constexpr char kSessions[] = "isthmus.v1.SessionService", kMap[] = "isthmus.v1.MapService",
               kEdits[] = "isthmus.v1.EditService", kAdmin[] = "isthmus.v1.AdminService";

ServerOptions Quick() {
  ServerOptions options;
  options.health_interval = std::chrono::milliseconds(5);
  return options;
}

class HealthTest : public RpcTest {
 protected:
  HealthTest() : RpcTest(Quick()) {}

  void SetLoad(const ServerLoad& load) {
    MutexLock lock(&pipeline_.load_mutex);
    pipeline_.load = load;
  }
  HealthStatus Now(const std::string& service) { return HealthWatcher(channel_, service).Next(); }
};

TEST_F(HealthTest, WhatCannotBeStoredDegradesWhatStores) {
  HealthWatcher sessions(channel_, kSessions), edits(channel_, kEdits);
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  EXPECT_EQ(edits.Next(), HealthStatus::kServing);
  ServerLoad load;
  load.storage_problem = "the server cannot store: disk full";
  SetLoad(load);
  EXPECT_EQ(sessions.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(edits.Next(), HealthStatus::kNotServing);
  for (const char* well :
       {"", kMap, kAdmin, "isthmus.v1.LocalisationService", "isthmus.v1.AccessService"}) {
    EXPECT_EQ(Now(well), HealthStatus::kServing) << well;
  }
  SetLoad({});
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  EXPECT_EQ(edits.Next(), HealthStatus::kServing);
}

TEST_F(HealthTest, AReplicaServesThoseWhoRead) {
  HealthWatcher sessions(channel_, kSessions), edits(channel_, kEdits);
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  EXPECT_EQ(edits.Next(), HealthStatus::kServing);
  ServerLoad load;
  load.replica = ReplicaState();
  SetLoad(load);
  EXPECT_EQ(sessions.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(edits.Next(), HealthStatus::kNotServing);
  for (const char* well : {"", kMap, kAdmin, "isthmus.v1.LocalisationService"}) {
    EXPECT_EQ(Now(well), HealthStatus::kServing) << well;
  }
}

TEST_F(HealthTest, AnAlmostFullDiskSendsRobotsElsewhere) {
  HealthWatcher sessions(channel_, kSessions);
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  ServerLoad load;
  load.disk.total_bytes = uint64_t{100} << 30;
  load.disk.free_bytes = uint64_t{100} << 20;
  SetLoad(load);
  EXPECT_EQ(sessions.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(Now(kEdits), HealthStatus::kServing);
  EXPECT_EQ(Now(""), HealthStatus::kServing) << "restarting the server would not help";
  load.disk.free_bytes = uint64_t{1} << 30;
  SetLoad(load);
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
}

TEST_F(HealthTest, AMapThatIsComposedAfterTheStartIsNotServed) {
  HealthWatcher map(channel_, kMap);
  EXPECT_EQ(map.Next(), HealthStatus::kServing);
  ServerLoad load;
  load.map_is_loading = true;
  SetLoad(load);
  EXPECT_EQ(map.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(Now(kSessions), HealthStatus::kServing);
  SetLoad({});
  EXPECT_EQ(map.Next(), HealthStatus::kServing);
}

TEST_F(HealthTest, AtTheEndNothingServes) {
  HealthWatcher server(channel_, ""), sessions(channel_, kSessions), admin(channel_, kAdmin);
  EXPECT_EQ(server.Next(), HealthStatus::kServing);
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  EXPECT_EQ(admin.Next(), HealthStatus::kServing);
  server_->Shutdown(std::chrono::seconds(1));
  EXPECT_EQ(server.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(sessions.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(admin.Next(), HealthStatus::kNotServing);
}

TEST(HealthOfSites, OneInTroubleIsEnough) {
  FakePipeline first, second;
  {
    MutexLock lock(&second.load_mutex);
    second.load.map_is_loading = true;
  }
  ServerOptions options = Quick();
  options.listen = "127.0.0.1:0";
  const auto server = RpcServer::Start(
      {{.name = "default", .pipeline = &first}, {.name = "yard", .pipeline = &second}}, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto channel =
      grpc::CreateChannel((*server)->address(), grpc::InsecureChannelCredentials());
  EXPECT_EQ(HealthWatcher(channel, kMap).Next(), HealthStatus::kNotServing);
  EXPECT_EQ(HealthWatcher(channel, kSessions).Next(), HealthStatus::kServing);
}

}  // namespace
}  // namespace isthmus::rpc
