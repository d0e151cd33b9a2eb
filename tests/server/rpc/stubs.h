// A client's stubs, and how tests look at what comes back.
#pragma once

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>

#include "isthmus/v1/graph_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
#include "isthmus/v1/match_service.grpc.pb.h"
#include "isthmus/v1/session_service.grpc.pb.h"
#include "server/rpc/server.h"

namespace isthmus::rpc {

// A call that hangs fails its test instead of the whole run.
inline std::unique_ptr<grpc::ClientContext> NewContext() {
  auto context = std::make_unique<grpc::ClientContext>();
  context->set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  return context;
}

inline std::string Describe(const grpc::Status& status) {
  return std::to_string(status.error_code()) + ": " + status.error_message();
}

#define EXPECT_GRPC_OK(expression)                                        \
  do {                                                                    \
    const grpc::Status grpc_status = (expression);                        \
    EXPECT_TRUE(grpc_status.ok()) << isthmus::rpc::Describe(grpc_status); \
  } while (false)

// The code, and that the message has `part` in it.
#define EXPECT_GRPC_ERROR(expression, code, part)                       \
  do {                                                                  \
    const grpc::Status grpc_status = (expression);                      \
    EXPECT_EQ(grpc_status.error_code(), grpc::StatusCode::code)         \
        << isthmus::rpc::Describe(grpc_status);                         \
    EXPECT_THAT(grpc_status.error_message(), testing::HasSubstr(part)); \
  } while (false)

// One stub per service, over one connection.
struct Stubs {
  explicit Stubs(const std::shared_ptr<grpc::Channel>& channel)
      : sessions(v1::SessionService::NewStub(channel)),
        map(v1::MapService::NewStub(channel)),
        matches(v1::MatchService::NewStub(channel)),
        graph(v1::GraphService::NewStub(channel)) {}
  std::unique_ptr<v1::SessionService::Stub> sessions;
  std::unique_ptr<v1::MapService::Stub> map;
  std::unique_ptr<v1::MatchService::Stub> matches;
  std::unique_ptr<v1::GraphService::Stub> graph;

  // Creates a session and returns its id.
  std::string NewSession(const std::string& robot, const std::string& sensor = "vlp16") {
    v1::CreateSessionRequest request;
    request.set_robot(robot);
    request.set_sensor(sensor);
    v1::Session session;
    EXPECT_GRPC_OK(sessions->CreateSession(NewContext().get(), request, &session));
    return session.id();
  }
};

}  // namespace isthmus::rpc
