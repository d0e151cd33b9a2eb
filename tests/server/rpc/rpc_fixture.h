// A server on a real socket over a fake pipeline.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/server/rpc/fake_pipeline.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {

class RpcTest : public testing::Test {
 protected:
  explicit RpcTest(ServerOptions options = {}) {
    options.listen = "127.0.0.1:0";
    auto started = RpcServer::Start(&pipeline_, options);
    if (!started.ok()) throw std::runtime_error(std::string(started.status().message()));
    server_ = *std::move(started);
    channel_ = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
    stubs_ = std::make_unique<Stubs>(channel_);
  }

  FakePipeline pipeline_;
  std::unique_ptr<RpcServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stubs> stubs_;
};

}  // namespace isthmus::rpc
