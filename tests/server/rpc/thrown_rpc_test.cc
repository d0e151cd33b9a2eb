// Handlers in which something is thrown: the call fails, and the server answers the next.
#include <atomic>
#include <new>
#include <stdexcept>

#include "tests/server/rpc/fake_pipeline.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {
namespace {

class ThrowingPipeline : public FakePipeline {
 public:
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) const override {
    if (a == RobotId("large")) throw std::bad_alloc();
    if (a == RobotId("odd")) throw std::runtime_error("an odd robot");
    return FakePipeline::GetTransform(a, b);
  }
  absl::StatusOr<bool> OfferScan(const SessionId&, ScanUpload*) override { throw std::bad_alloc(); }
};

TEST(ThrownRpc, IsTheAnswerToThatCallAlone) {
  ThrowingPipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  std::atomic<int> told = 0;
  options.on_failed_call = [&](const FailedCall&) { ++told; };
  const auto server = RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const Stubs stubs((*server)->InProcessChannel());
  const auto ask = [&](const std::string& robot) {
    v1::GetTransformRequest request;
    request.set_robot_a(robot);
    v1::GetTransformResponse response;
    return stubs.map->GetTransform(NewContext().get(), request, &response);
  };
  EXPECT_GRPC_ERROR(ask("large"), RESOURCE_EXHAUSTED, "not enough memory");
  EXPECT_GRPC_ERROR(ask("odd"), INTERNAL, "an odd robot");
  EXPECT_EQ(told, 2);
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs.map->GetMapInfo(NewContext().get(), {}, &info));
}

// Nobody waits for acknowledgements that nobody will write.
TEST(ThrownRpc, EndsAStreamOfScans) {
  ThrowingPipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  const auto server = RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  Stubs stubs((*server)->InProcessChannel());
  const auto context = NewContext();
  const auto stream = stubs.sessions->StreamScans(context.get());
  v1::StreamScansRequest request;
  request.set_session(stubs.NewSession("alice"));
  request.mutable_scan()->set_sequence(1);
  stream->Write(request);
  v1::StreamScansResponse ack;
  while (stream->Read(&ack)) {
  }
  EXPECT_GRPC_ERROR(stream->Finish(), RESOURCE_EXHAUSTED, "not enough memory");
}

}  // namespace
}  // namespace isthmus::rpc
