// A client's stubs, and how tests look at what comes back.
#pragma once

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "isthmus/v1/access_service.grpc.pb.h"
#include "isthmus/v1/admin_service.grpc.pb.h"
#include "isthmus/v1/edit_service.grpc.pb.h"
#include "isthmus/v1/event_service.grpc.pb.h"
#include "isthmus/v1/map_service.grpc.pb.h"
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

#define ASSERT_GRPC_OK(expression)                                        \
  do {                                                                    \
    const grpc::Status grpc_status = (expression);                        \
    ASSERT_TRUE(grpc_status.ok()) << isthmus::rpc::Describe(grpc_status); \
  } while (false)

// The code, and that the message has `part` in it.
#define EXPECT_GRPC_ERROR(expression, code, part)                       \
  do {                                                                  \
    const grpc::Status grpc_status = (expression);                      \
    EXPECT_EQ(grpc_status.error_code(), grpc::StatusCode::code)         \
        << isthmus::rpc::Describe(grpc_status);                         \
    EXPECT_THAT(grpc_status.error_message(), testing::HasSubstr(part)); \
  } while (false)

// Reads a stream to its end.
template <typename Response>
grpc::Status ReadAll(std::unique_ptr<grpc::ClientReader<Response>> reader,
                     std::vector<Response>* responses) {
  responses->clear();
  Response response;
  while (reader->Read(&response)) responses->push_back(response);
  return reader->Finish();
}

// The same as one response that holds the content of all.
template <typename Response>
grpc::Status Merged(std::unique_ptr<grpc::ClientReader<Response>> reader, Response* whole) {
  std::vector<Response> responses;
  const grpc::Status status = ReadAll(std::move(reader), &responses);
  whole->Clear();
  for (const Response& response : responses) whole->MergeFrom(response);
  return status;
}

// One stub per service, over one connection.
struct Stubs {
  explicit Stubs(const std::shared_ptr<grpc::Channel>& channel)
      : sessions(v1::SessionService::NewStub(channel)),
        map(v1::MapService::NewStub(channel)),
        edits(v1::EditService::NewStub(channel)),
        admin(v1::AdminService::NewStub(channel)),
        access(v1::AccessService::NewStub(channel)),
        events(v1::EventService::NewStub(channel)) {}
  std::unique_ptr<v1::SessionService::Stub> sessions;
  std::unique_ptr<v1::MapService::Stub> map;
  std::unique_ptr<v1::EditService::Stub> edits;
  std::unique_ptr<v1::AdminService::Stub> admin;
  std::unique_ptr<v1::AccessService::Stub> access;
  std::unique_ptr<v1::EventService::Stub> events;

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
