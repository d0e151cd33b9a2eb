// The server's offers beside its own services: health, reflection, limits, ports, stopping.
#include "server/rpc/server.h"

#include <google/protobuf/unknown_field_set.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <functional>
#include <thread>

#include "tests/server/rpc/generic_call.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using google::protobuf::UnknownField;
using google::protobuf::UnknownFieldSet;

// Health and reflection have no headers in Debian's package: their messages are written and read by
// field number.
std::string ToBytes(const UnknownFieldSet& message) {
  std::string bytes;
  EXPECT_TRUE(message.SerializeToString(&bytes));
  return bytes;
}

// One request, and the response.
grpc::Status Call(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::string& request, UnknownFieldSet* response) {
  std::string bytes;
  const grpc::Status status = GenericCall(channel, method, {}, request, &bytes);
  EXPECT_TRUE(response->ParseFromString(bytes));
  return status;
}

// grpc.health.v1.HealthCheckResponse.status; 1 is SERVING.
uint64_t Health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  UnknownFieldSet request;
  request.AddLengthDelimited(1, service);
  UnknownFieldSet response;
  EXPECT_GRPC_OK(Call(channel, "/grpc.health.v1.Health/Check", ToBytes(request), &response));
  return response.field_count() == 1 ? response.field(0).varint() : 0;
}

using ServerTest = RpcTest;

TEST_F(ServerTest, HealthOfTheServerAndOfEachService) {
  EXPECT_EQ(Health(channel_, ""), 1u);
  EXPECT_EQ(Health(channel_, "isthmus.v1.SessionService"), 1u);
  EXPECT_EQ(Health(channel_, "isthmus.v1.MapService"), 1u);
  EXPECT_EQ(Health(channel_, "isthmus.v1.MapService"), 1u);
  EXPECT_EQ(Health(channel_, "isthmus.v1.EditService"), 1u);
}

TEST_F(ServerTest, ReflectionListsTheServices) {
  UnknownFieldSet request;
  request.AddLengthDelimited(7, "*");  // list_services
  UnknownFieldSet response;
  EXPECT_GRPC_OK(Call(channel_, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                      ToBytes(request), &response));
  std::string services;
  for (int i = 0; i < response.field_count(); ++i) {
    if (response.field(i).number() == 6) services = response.field(i).length_delimited();
  }
  EXPECT_THAT(services, testing::HasSubstr("isthmus.v1.SessionService"));
  EXPECT_THAT(services, testing::HasSubstr("isthmus.v1.MapService"));
  EXPECT_THAT(services, testing::HasSubstr("isthmus.v1.EditService"));
}

TEST_F(ServerTest, APortThatIsTakenIsAnErrorThatNamesIt) {
  ServerOptions options;
  options.listen = server_->address();
  const auto second = RpcServer::Start(&pipeline_, options);
  ASSERT_FALSE(second.ok());
  EXPECT_TRUE(absl::IsUnavailable(second.status()));
  EXPECT_THAT(std::string(second.status().message()), testing::HasSubstr(server_->address()));
}

TEST_F(ServerTest, AnAddressThatIsNoneIsAnError) {
  ServerOptions options;
  options.listen = "nowhere.invalid:1";
  EXPECT_FALSE(RpcServer::Start(&pipeline_, options).ok());
}

TEST_F(ServerTest, TheAddressHasThePortThatWasChosen) {
  EXPECT_GT(server_->port(), 0);
  EXPECT_EQ(server_->address(), "127.0.0.1:" + std::to_string(server_->port()));
}

TEST_F(ServerTest, TheSameServerCanBeReachedWithoutASocket) {
  const std::string session = stubs_->NewSession("alice");
  Stubs inside(server_->InProcessChannel());
  v1::ListSessionsResponse list;
  EXPECT_GRPC_OK(Merged(inside.sessions->ListSessions(NewContext().get(), {}), &list));
  ASSERT_EQ(list.sessions_size(), 1);
  EXPECT_EQ(list.sessions(0).id(), session);
}

TEST_F(ServerTest, AfterShutdownCallsAreUnavailable) {
  server_->Shutdown(std::chrono::seconds(1));
  v1::ListSessionsResponse list;
  EXPECT_EQ(Merged(stubs_->sessions->ListSessions(NewContext().get(), {}), &list).error_code(),
            grpc::StatusCode::UNAVAILABLE);
  server_->Shutdown(std::chrono::seconds(1));
}

TEST(FailedCallTest, IsReportedWithItsNameAndStatus) {
  FakePipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  std::vector<std::string> failed;  // One call at a time below.
  options.on_failed_call = [&](const std::string& rpc, const absl::Status& status) {
    failed.push_back(rpc + ": " + std::string(status.message()));
  };
  const auto server = RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  Stubs stubs((*server)->InProcessChannel());
  const std::string session = stubs.NewSession("alice");
  EXPECT_TRUE(failed.empty());
  v1::GetSessionRequest request;
  request.set_session("nobody-1");
  v1::Session response;
  EXPECT_GRPC_ERROR(stubs.sessions->GetSession(NewContext().get(), request, &response), NOT_FOUND,
                    "nobody-1");
  EXPECT_THAT(failed, testing::ElementsAre(testing::HasSubstr("GetSession: no session")));
}

TEST(EndedCallTest, IsReportedWithItsCodeAndHowLongItTook) {
  FakePipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  std::vector<std::string> ended;  // One call at a time below.
  options.on_ended_call = [&](const std::string& rpc, absl::StatusCode code, double seconds) {
    ended.push_back(rpc + ": " + absl::StatusCodeToString(code));
    EXPECT_GE(seconds, 0);
    EXPECT_LT(seconds, 20);
  };
  const auto server = RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  Stubs stubs((*server)->InProcessChannel());
  const std::string session = stubs.NewSession("alice");
  v1::GetSessionRequest request;
  request.set_session("nobody-1");
  v1::Session response;
  EXPECT_GRPC_ERROR(stubs.sessions->GetSession(NewContext().get(), request, &response), NOT_FOUND,
                    "nobody-1");
  const auto context = NewContext();
  const auto wire = stubs.sessions->StreamScans(context.get());
  wire->WritesDone();
  EXPECT_GRPC_ERROR(wire->Finish(), INVALID_ARGUMENT, "must name its session");
  EXPECT_THAT(ended, testing::ElementsAre("CreateSession: OK", "GetSession: NOT_FOUND",
                                          "StreamScans: INVALID_ARGUMENT"));
}

class SmallMessagesTest : public RpcTest {
 protected:
  static ServerOptions Small() {
    ServerOptions options;
    options.max_receive_bytes = 1000;
    return options;
  }
  SmallMessagesTest() : RpcTest(Small()) {}
};

TEST_F(SmallMessagesTest, AMessageBeyondTheLimitEndsItsCallOnly) {
  v1::CreateSessionRequest request;
  request.set_robot(std::string(2000, 'a'));
  v1::Session session;
  EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(NewContext().get(), request, &session),
                    RESOURCE_EXHAUSTED, "larger than max");
  request.set_robot("alice");
  EXPECT_GRPC_OK(stubs_->sessions->CreateSession(NewContext().get(), request, &session));
}

}  // namespace
}  // namespace isthmus::rpc
