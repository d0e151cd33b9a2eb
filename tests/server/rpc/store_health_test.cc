// Health while the store of a real pipeline fails, and once it is well again.
#include "storage/memory_store.h"
#include "tests/server/rpc/health_watcher.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::rpc {
namespace {

TEST(StoreHealthRpcTest, RobotsAreToldToGoElsewhereWhileNothingCanBeStored) {
  const auto faults = std::make_shared<storage::Faults>();
  const auto pipeline =
      server::Pipeline::Open({}, storage::MakeFaultyStore(storage::MakeMemoryStore(), faults))
          .value();
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.health_interval = std::chrono::milliseconds(5);
  const auto server = RpcServer::Start(pipeline.get(), options).value();
  const auto channel = grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials());
  Stubs stubs(channel);
  HealthWatcher sessions(channel, "isthmus.v1.SessionService");
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
  EXPECT_EQ(HealthWatcher(channel, "isthmus.v1.MapService").Next(), HealthStatus::kServing)
      << "there is nothing to wait for";

  faults->SetDiskFull(true);
  v1::CreateSessionRequest request;
  request.set_robot("alice");
  request.set_sensor("vlp16");
  v1::Session session;
  EXPECT_EQ(stubs.sessions->CreateSession(NewContext().get(), request, &session).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(sessions.Next(), HealthStatus::kNotServing);
  EXPECT_EQ(HealthWatcher(channel, "").Next(), HealthStatus::kServing);
  EXPECT_EQ(HealthWatcher(channel, "isthmus.v1.MapService").Next(), HealthStatus::kServing);
  v1::ServerStatus status;
  EXPECT_GRPC_OK(stubs.admin->GetStatus(NewContext().get(), v1::GetStatusRequest(), &status));
  ASSERT_GE(status.degraded_size(), 1);
  EXPECT_THAT(status.degraded(0).why(), testing::HasSubstr("the disk is full"));

  faults->SetDiskFull(false);
  EXPECT_GRPC_OK(stubs.sessions->CreateSession(NewContext().get(), request, &session));
  EXPECT_EQ(sessions.Next(), HealthStatus::kServing);
}

}  // namespace
}  // namespace isthmus::rpc
