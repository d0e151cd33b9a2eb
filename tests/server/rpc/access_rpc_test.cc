// Tokens over a real socket: made, listed, revoked; a change acts on calls under way.
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <map>

#include "core/concurrency/mutex.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "tests/server/rpc/fake_pipeline.h"
#include "tests/server/rpc/generic_call.h"

namespace isthmus::rpc {
namespace {

using grpc::StatusCode;

const char kReflection[] = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";
const std::string kListServices("\x3a\x01*");  // ServerReflectionRequest.list_services.

class AccessRpcTest : public testing::Test {
 protected:
  AccessRpcTest() {
    std::string pattern = testing::TempDir() + "isthmus-access-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
    tokens_ = *access::Tokens::Open(folder_);
    Start(access::RequireToken::kAuto);
  }
  ~AccessRpcTest() override { std::filesystem::remove_all(folder_); }

  void Start(access::RequireToken require) {
    server_.reset();
    ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.tokens = tokens_.get();
    options.require_token = require;
    options.token_review_interval = std::chrono::milliseconds(20);
    options.on_failed_call = [this](const FailedCall& call) {
      MutexLock lock(&failed_mutex_);
      failed_.push_back(call);
    };
    server_ = *RpcServer::Start(&pipeline_, options);
    channel_ = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
    stubs_ = std::make_unique<Stubs>(channel_);
  }

  static std::unique_ptr<grpc::ClientContext> As(const std::string& secret) {
    auto context = NewContext();
    if (!secret.empty()) context->AddMetadata("authorization", "Bearer " + secret);
    return context;
  }
  // The secret.
  grpc::Status Create(const std::string& by, const std::string& name, v1::Role role,
                      const std::vector<std::string>& robots, const std::vector<std::string>& sites,
                      std::string* secret) {
    v1::CreateTokenRequest request;
    request.mutable_token()->set_name(name);
    request.mutable_token()->set_role(role);
    for (const std::string& robot : robots) request.mutable_token()->add_robots(robot);
    for (const std::string& site : sites) request.mutable_token()->add_sites(site);
    v1::CreateTokenResponse response;
    const auto status = stubs_->access->CreateToken(As(by).get(), request, &response);
    if (secret != nullptr) *secret = response.secret();
    return status;
  }
  std::string Admin() {
    std::string secret;
    EXPECT_GRPC_OK(Create("", "chief", v1::ROLE_ADMIN, {}, {}, &secret));
    return secret;
  }
  std::vector<std::string> Names(const std::string& by) {
    v1::ListTokensResponse response;
    EXPECT_GRPC_OK(Merged(stubs_->access->ListTokens(As(by).get(), {}), &response));
    std::vector<std::string> names;
    for (const v1::Token& token : response.tokens()) names.push_back(token.name());
    return names;
  }
  grpc::Status Revoke(const std::string& by, const std::string& name, v1::Token* token) {
    v1::RevokeTokenRequest request;
    request.set_name(name);
    return stubs_->access->RevokeToken(As(by).get(), request, token);
  }
  grpc::Status GetInfo(const std::string& by) {
    v1::MapInfo info;
    return stubs_->map->GetMapInfo(As(by).get(), {}, &info);
  }

  std::vector<FailedCall> Failed() {
    MutexLock lock(&failed_mutex_);
    return failed_;
  }

  std::string folder_;
  std::unique_ptr<access::Tokens> tokens_;
  Mutex failed_mutex_;
  std::vector<FailedCall> failed_ ABSL_GUARDED_BY(failed_mutex_);
  FakePipeline pipeline_;
  std::unique_ptr<RpcServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(AccessRpcTest, OpenUntilTheFirstTokenIsMade) {
  EXPECT_GRPC_OK(GetInfo(""));
  EXPECT_GRPC_OK(GetInfo("a token that nobody asked for"));
  const std::string chief = Admin();
  EXPECT_GRPC_ERROR(GetInfo(""), UNAUTHENTICATED, "authorization: Bearer");
  EXPECT_GRPC_OK(GetInfo(chief));
}

TEST_F(AccessRpcTest, AlwaysAndNever) {
  Start(access::RequireToken::kAlways);
  EXPECT_GRPC_ERROR(GetInfo(""), UNAUTHENTICATED, "isthmus token create");
  ASSERT_TRUE(tokens_->Create({"r", AccessRole::kReader, {}, {"default"}}).ok());
  Start(access::RequireToken::kNever);
  EXPECT_GRPC_OK(GetInfo(""));
}

// By the table that refuses, so that a page need not have one of its own.
TEST_F(AccessRpcTest, TheStatusSaysWhatItsCallerMayNotCall) {
  const auto refused = [&](const std::string& by) {
    v1::ServerStatus status;
    EXPECT_GRPC_OK(stubs_->admin->GetStatus(As(by).get(), {}, &status));
    std::map<std::string, std::string> why;
    for (const v1::RefusedMethod& one : status.refused()) why[one.method()] = one.why();
    return why;
  };
  EXPECT_TRUE(refused("").empty()) << "without tokens everybody may do everything";
  const std::string chief = Admin();
  std::string reader, feeder, operator_token;
  ASSERT_GRPC_OK(Create(chief, "reader", v1::ROLE_READER, {}, {}, &reader));
  ASSERT_GRPC_OK(Create(chief, "feeder", v1::ROLE_READER, {"alice"}, {}, &feeder));
  ASSERT_GRPC_OK(Create(chief, "operator", v1::ROLE_OPERATOR, {}, {}, &operator_token));
  EXPECT_TRUE(refused(chief).empty());
  auto of_reader = refused(reader);
  for (const char* edit : {"DecideMatch", "DecideLoop", "PutAnchor", "DeleteAnchor", "UndoRevision",
                           "ListEvents", "StreamScans", "CreateToken"}) {
    EXPECT_TRUE(of_reader.contains(edit)) << edit;
  }
  for (const char* read : {"GetStatus", "ExportMap", "WatchMap"}) {
    EXPECT_FALSE(of_reader.contains(read)) << read;
  }
  EXPECT_THAT(of_reader["DecideMatch"],
              testing::AllOf(testing::HasSubstr("operator"), testing::HasSubstr("role is reader")));
  EXPECT_FALSE(refused(feeder).contains("StreamScans"));
  EXPECT_TRUE(refused(feeder).contains("DecideMatch"));
  EXPECT_FALSE(refused(operator_token).contains("DecideMatch"));
  EXPECT_TRUE(refused(operator_token).contains("CreateToken"));
}

TEST_F(AccessRpcTest, WhoeverHasATokenLearnsWhatItIsFor) {
  v1::Token own;
  EXPECT_GRPC_OK(stubs_->access->GetOwnToken(As("").get(), {}, &own));
  EXPECT_EQ(own.name(), "");
  EXPECT_EQ(own.role(), v1::ROLE_ADMIN) << "none is asked for yet";
  const std::string chief = Admin();
  std::string alice;
  ASSERT_GRPC_OK(Create(chief, "alice-key", v1::ROLE_ROBOT, {"alice"}, {}, &alice));
  EXPECT_GRPC_OK(stubs_->access->GetOwnToken(As(alice).get(), {}, &own));
  EXPECT_EQ(own.name(), "alice-key");
  EXPECT_EQ(own.role(), v1::ROLE_ROBOT);
  EXPECT_THAT(own.robots(), testing::ElementsAre("alice"));
  EXPECT_THAT(own.sites(), testing::ElementsAre("default"));
  EXPECT_GT(own.created_ns(), 0);
  EXPECT_GRPC_ERROR(stubs_->access->GetOwnToken(As("").get(), {}, &own), UNAUTHENTICATED, "");
  EXPECT_GRPC_ERROR(stubs_->access->GetOwnToken(As("isthmus_no").get(), {}, &own), UNAUTHENTICATED,
                    "");
}

TEST_F(AccessRpcTest, ATokenForOneRobotNamesTheOneThatIsLocalised) {
  const std::string chief = Admin();
  std::string alice, both;
  ASSERT_GRPC_OK(Create(chief, "alice", v1::ROLE_ROBOT, {"alice"}, {}, &alice));
  ASSERT_GRPC_OK(Create(chief, "both", v1::ROLE_ROBOT, {"alice", "cart-*"}, {}, &both));
  const auto stub = v1::LocalisationService::NewStub(channel_);
  const auto localise = [&](const std::string& by, const std::string& robot) {
    v1::LocaliseRequest request;
    request.mutable_begin()->set_sensor("vlp16");
    request.mutable_begin()->set_robot(robot);
    const auto context = As(by);
    auto wire = stub->Localise(context.get());
    wire->Write(request);
    return wire->Finish();
  };
  EXPECT_GRPC_ERROR(localise(alice, ""), UNIMPLEMENTED, "");  // As the pipeline is a fake.
  EXPECT_EQ(pipeline_.asked_localisation.robot, RobotId("alice"));
  EXPECT_GRPC_ERROR(localise(alice, "bob"), PERMISSION_DENIED, "alice");
  EXPECT_GRPC_ERROR(localise(both, "cart-7"), UNIMPLEMENTED, "");
  EXPECT_EQ(pipeline_.asked_localisation.robot, RobotId("cart-7"));
  EXPECT_GRPC_ERROR(localise(both, ""), UNIMPLEMENTED, "");
  EXPECT_EQ(pipeline_.asked_localisation.robot, RobotId()) << "it may be either";
}

// A session's id goes before a robot's name, but the rights are those of the session's robot.
TEST_F(AccessRpcTest, ARobotThatIsCalledLikeAnothersSessionDoesNotReachIt) {
  const std::string chief = Admin();
  std::string secret;
  const SessionId session = pipeline_.sessions().Create({.robot = RobotId("bob")})->record.id;
  ASSERT_GRPC_OK(Create(chief, "sly", v1::ROLE_ROBOT, {session.value()}, {}, &secret));
  v1::GetSessionRequest get;
  get.set_session(session.value());
  v1::FinishSessionRequest finish;
  finish.set_session(session.value());
  v1::Session found;
  EXPECT_GRPC_ERROR(stubs_->sessions->GetSession(As(secret).get(), get, &found), NOT_FOUND, "");
  EXPECT_GRPC_ERROR(stubs_->sessions->FinishSession(As(secret).get(), finish, &found), NOT_FOUND,
                    "");
  v1::GetTrajectoryRequest way;
  way.set_robot(session.value());
  way.set_frame(v1::ODOM);
  v1::GetTrajectoryResponse poses;
  EXPECT_GRPC_ERROR(Merged(stubs_->map->GetTrajectory(As(secret).get(), way), &poses),
                    PERMISSION_DENIED, "");
}

TEST_F(AccessRpcTest, MadeListedAndRevoked) {
  const std::string chief = Admin();
  std::string alice;
  ASSERT_GRPC_OK(Create(chief, "alice", v1::ROLE_ROBOT, {"alice"}, {}, &alice));
  EXPECT_GRPC_ERROR(Create(chief, "alice", v1::ROLE_READER, {}, {}, nullptr), ALREADY_EXISTS,
                    "another name");
  EXPECT_GRPC_ERROR(Create(chief, "x", v1::ROLE_UNSPECIFIED, {}, {}, nullptr), INVALID_ARGUMENT,
                    "role");
  EXPECT_GRPC_ERROR(Create(chief, "x", v1::ROLE_ROBOT, {}, {}, nullptr), INVALID_ARGUMENT,
                    "robots");
  EXPECT_THAT(Names(chief), testing::ElementsAre("chief", "alice"));
  v1::CreateSessionRequest request;
  request.set_robot("alice");
  request.set_sensor("vlp16");
  v1::Session session;
  EXPECT_GRPC_OK(stubs_->sessions->CreateSession(As(alice).get(), request, &session));
  v1::Token revoked;
  ASSERT_GRPC_OK(Revoke(chief, "alice", &revoked));
  EXPECT_GT(revoked.revoked_ns(), 0);
  EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(As(alice).get(), request, &session),
                    UNAUTHENTICATED, "revoked");
  EXPECT_GRPC_ERROR(Revoke(chief, "nobody", &revoked), NOT_FOUND, "isthmus token list");
}

TEST_F(AccessRpcTest, AnAdministratorOfOneSiteStaysThere) {
  const std::string chief = Admin();
  std::string local, secret;
  ASSERT_GRPC_OK(Create(chief, "local", v1::ROLE_ADMIN, {}, {"default"}, &local));
  EXPECT_GRPC_ERROR(Create(local, "x", v1::ROLE_READER, {}, {"*"}, nullptr), PERMISSION_DENIED,
                    "sites");
  EXPECT_GRPC_ERROR(Create(local, "x", v1::ROLE_READER, {}, {"yard"}, nullptr), PERMISSION_DENIED,
                    "sites");
  ASSERT_GRPC_OK(Create(local, "mine", v1::ROLE_ADMIN, {}, {}, &secret));
  EXPECT_EQ(tokens_->List().back().sites, std::vector<std::string>{"default"});
  EXPECT_THAT(Names(local), testing::ElementsAre("local", "mine"));
  v1::Token revoked;
  EXPECT_GRPC_ERROR(Revoke(local, "chief", &revoked), NOT_FOUND, "");
  EXPECT_GRPC_OK(GetInfo(chief));
}

// Scans go in and out until the token is revoked; then the stream says why it ends.
TEST_F(AccessRpcTest, AStreamOfScansEndsWithItsToken) {
  const std::string chief = Admin();
  std::string alice;
  ASSERT_GRPC_OK(Create(chief, "alice", v1::ROLE_ROBOT, {"alice"}, {}, &alice));
  const auto created = pipeline_.sessions().Create({.robot = RobotId("alice"), .sensor = "vlp16"});
  const auto context = As(alice);
  const auto stream = stubs_->sessions->StreamScans(context.get());
  v1::StreamScansRequest request;
  request.set_session(created->record.id.value());
  ASSERT_TRUE(stream->Write(request));
  v1::Token revoked;
  uint64_t sequence = 0;
  v1::StreamScansResponse ack;
  const auto push = [&] {
    request.mutable_scan()->set_sequence(++sequence);
    return stream->Write(request) && stream->Read(&ack);
  };
  ASSERT_TRUE(push());
  ASSERT_GRPC_OK(Revoke(chief, "alice", &revoked));
  while (push()) {
  }
  EXPECT_GRPC_ERROR(stream->Finish(), UNAUTHENTICATED, "revoked");
}

// A client that says nothing is not waited for; nor is one that came before there were tokens.
TEST_F(AccessRpcTest, SilentStreamsEndToo) {
  (void)pipeline_.sessions().Create({.robot = RobotId("alice"), .sensor = "vlp16"});
  const auto context = As("");
  const auto stream = stubs_->sessions->StreamScans(context.get());
  v1::StreamScansRequest request;
  request.set_session("alice-1");
  request.mutable_scan()->set_sequence(1);
  ASSERT_TRUE(stream->Write(request));
  v1::StreamScansResponse ack;
  ASSERT_TRUE(stream->Read(&ack));
  Admin();
  EXPECT_FALSE(stream->Read(&ack));
  const StatusCode code = stream->Finish().error_code();
  EXPECT_TRUE(code == StatusCode::UNAUTHENTICATED || code == StatusCode::CANCELLED) << code;
}

TEST_F(AccessRpcTest, HealthStaysOpenAndReflectionIsForAdministrators) {
  std::string answer;
  EXPECT_GRPC_OK(GenericCall(channel_, kReflection, {}, kListServices, &answer));
  EXPECT_THAT(answer, testing::HasSubstr("isthmus.v1.AccessService"));
  const std::string chief = Admin();
  std::string reader;
  ASSERT_GRPC_OK(Create(chief, "r", v1::ROLE_READER, {}, {}, &reader));
  EXPECT_GRPC_OK(GenericCall(channel_, "/grpc.health.v1.Health/Check", {}, "", &answer));
  EXPECT_EQ(answer, "\x08\x01");  // SERVING.
  for (const Headers& headers : {Headers{}, Headers{{"authorization", "Bearer " + reader}}}) {
    const grpc::Status status = GenericCall(channel_, kReflection, headers, kListServices, &answer);
    EXPECT_EQ(status.error_code(), StatusCode::CANCELLED) << status.error_message();
    EXPECT_EQ(answer, "");
  }
  EXPECT_GRPC_OK(GenericCall(channel_, kReflection, {{"authorization", "Bearer " + chief}},
                             kListServices, &answer));
  EXPECT_THAT(answer, testing::HasSubstr("isthmus.v1.AccessService"));
}

TEST(NoTokens, AreKeptByAServerInAProgram) {
  FakePipeline pipeline;
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  const auto server = RpcServer::Start(&pipeline, options);
  const Stubs stubs((*server)->InProcessChannel());
  v1::Token token;
  EXPECT_GRPC_ERROR(stubs.access->RevokeToken(NewContext().get(), {}, &token), UNIMPLEMENTED, "");
}

// The log tells whose token is too weak; the reply does not.
TEST_F(AccessRpcTest, ARefusedCallIsReportedWithTheNameOfItsToken) {
  const std::string admin = Admin();
  std::string reader;
  ASSERT_GRPC_OK(Create(admin, "screen", v1::ROLE_READER, {}, {}, &reader));
  v1::Token token;
  EXPECT_GRPC_ERROR(Revoke(reader, "chief", &token), PERMISSION_DENIED, "");
  EXPECT_GRPC_ERROR(GetInfo("nonsense"), UNAUTHENTICATED, "");
  const std::vector<FailedCall> failed = Failed();
  ASSERT_EQ(failed.size(), 2u);
  EXPECT_EQ(failed[0].token, "screen");
  EXPECT_EQ(failed[0].site, "");
  EXPECT_EQ(failed[1].token, "");
}

}  // namespace
}  // namespace isthmus::rpc
