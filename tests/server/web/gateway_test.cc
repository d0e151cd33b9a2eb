// The API over HTTP: answers, streams, errors, and whose call it is.
#include <absl/time/clock.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;
using testing::StartsWith;

class GatewayTest : public WebTest {
 protected:
  // Until a call has ended, or it is late.
  void AwaitEnded() {
    const absl::Time late = absl::Now() + absl::Seconds(20);
    while (ended().empty() && absl::Now() < late) std::this_thread::yield();
  }
};

TEST_F(GatewayTest, ACallWithOneAnswerIsAnObjectOfJson) {
  pipeline_.info.revision = 1234567890123456789;
  pipeline_.info.robots = {RobotId("alice")};
  Start();
  const http::Reply reply = Call("MapService/GetMapInfo");
  EXPECT_EQ(reply.code, 200);
  EXPECT_EQ(reply.headers.at("content-type"), "application/json");
  EXPECT_EQ(reply.headers.at("cache-control"), "no-store");
  const json info = json::parse(reply.body);
  EXPECT_EQ(info["revision"], "1234567890123456789");  // As text: JavaScript's numbers end at 2^53.
  EXPECT_EQ(info["robots"], json({"alice"}));
  EXPECT_EQ(Call("MapService/GetMapInfo", "").code, 200);  // Nothing is an empty request.
  EXPECT_THAT(ended(), Contains(Pair("GetMapInfo", absl::StatusCode::kOk)));
}

TEST_F(GatewayTest, ProtobufIsAnsweredByProtobuf) {
  pipeline_.info.revision = 7;
  pipeline_.revisions = std::vector<RevisionInfo>(1);
  pipeline_.revisions->front().revision = 7;
  Start();
  const std::string header = "Content-Type: application/x-protobuf\r\n";
  const http::Reply reply =
      http::Ask(address_, "POST", "/rpc/isthmus.v1.MapService/GetMapInfo", header);
  v1::MapInfo info;
  ASSERT_TRUE(info.ParseFromString(reply.body));
  EXPECT_EQ(info.revision(), 7);

  v1::ListRevisionsRequest request;
  request.set_limit(3);
  const std::string frames = http::Ask(address_, "POST", "/rpc/isthmus.v1.MapService/ListRevisions",
                                       header, request.SerializeAsString())
                                 .body;
  EXPECT_EQ(pipeline_.asked_limit, 3);
  ASSERT_GT(frames.size(), 5u);
  EXPECT_EQ(frames.substr(0, 4), std::string(4, '\0'));
  ASSERT_EQ(frames.size(), 5u + static_cast<unsigned char>(frames[4]));
  v1::ListRevisionsResponse response;
  ASSERT_TRUE(response.ParseFromString(frames.substr(5)));
  EXPECT_EQ(response.revisions(0).revision(), 7);
}

TEST_F(GatewayTest, AStreamIsALineForEachMessageAsTheyCome) {
  Start();
  http::Conversation conversation(address_);
  Begin(&conversation, "EventService/WatchEvents", "{}");
  EXPECT_THAT(conversation.ReadUntil("\r\n\r\n"),
              AllOf(HasSubstr("200 OK"), HasSubstr("application/x-ndjson")));
  Event event;
  event.kind = EventKind::kRobotLost;
  for (const char* text : {"first", "second"}) {
    event.text = text;
    pipeline_.events().Note(event);
    const std::string read = conversation.ReadUntil(std::string(text) + "\"");
    EXPECT_THAT(read, AllOf(HasSubstr("ROBOT_LOST"), EndsWith(std::string(text) + "\"")));
  }
  // A silent stream says that it is alive.
  EXPECT_THAT(conversation.ReadUntil("\r\n1\r\n\n\r\n"), EndsWith("\r\n1\r\n\n\r\n"));
}

TEST_F(GatewayTest, ErrorsHaveTheirCodeOfHttpAndTheirWords) {
  Start();
  const http::Reply reply = Call("MapService/GetTransform", R"({"robotA": "a", "robotB": "b"})");
  EXPECT_EQ(reply.code, 404);
  EXPECT_EQ(json::parse(reply.body)["code"], "NOT_FOUND");
  EXPECT_EQ(json::parse(reply.body)["message"], "no such robot");
  // A stream fails before its first message.
  EXPECT_EQ(Call("MapService/GetTrajectory", R"({"robot": "a", "frame": "MAP"})").code, 404);
  EXPECT_EQ(Call("MapService/GetTrajectory", R"({"robot": "a"})").code, 400);
  for (const char* unknown : {"MapService/Nothing", "NoService/GetMapInfo", "MapService", "",
                              "MapService/../MapService/GetMapInfo/x"}) {
    EXPECT_EQ(Call(unknown).code, 404) << unknown;
  }
  EXPECT_EQ(Post("/rpc/grpc.health.v1.Health/Check", "{}").code, 404);
  EXPECT_EQ(Call("SessionService/StreamScans").code, 501);
  EXPECT_EQ(Get("/rpc/isthmus.v1.MapService/GetMapInfo").code, 405);
}

TEST_F(GatewayTest, WhatIsNoRequestIsRefusedAndTheNextIsServed) {
  Start();
  std::string deep = R"({"robotA": )";
  for (int i = 0; i < 100'000; ++i) deep += '[';
  for (const std::string& broken :
       {std::string("{"), std::string("[]"), std::string("\"x\""), std::string("{\"robotA\": 1}"),
        std::string("{\"nothing\": 1}"), std::string("\xff\xfe"), std::string(1000, '\0'),
        std::string("{\"robotA\": \"\xff\"}"), deep}) {
    const http::Reply reply = Call("MapService/GetTransform", broken);
    EXPECT_EQ(reply.code, 400) << broken.substr(0, 100);
    EXPECT_EQ(json::parse(reply.body)["code"], "INVALID_ARGUMENT");
  }
  EXPECT_EQ(http::Ask(address_, "POST", "/rpc/isthmus.v1.MapService/GetTransform",
                      "Content-Type: application/x-protobuf\r\n", "\xff\xff\xff")
                .code,
            400);
  EXPECT_EQ(Call("MapService/GetMapInfo", std::string((1 << 20) + 1, ' ')).code, 413);
  EXPECT_EQ(Call("MapService/GetMapInfo").code, 200);
}

TEST_F(GatewayTest, TokensAndRolesAreThoseOfGrpc) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  const std::string robot = NewToken("alice", AccessRole::kRobot);
  Start();
  const http::Reply without = Call("MapService/GetMapInfo");
  EXPECT_EQ(without.code, 401);
  EXPECT_EQ(without.headers.at("www-authenticate"), "Bearer");
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", Bearer("isthmus_wrong")).code, 401);
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", Bearer(std::string(5000, 'a'))).code, 401);
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", Bearer(reader)).code, 200);
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", "Cookie: isthmus_token=" + reader + "\r\n").code,
            200);
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", Bearer(robot)).code, 403);
  EXPECT_EQ(Call("EditService/UndoRevision", "{}", Bearer(reader)).code, 403);
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", Bearer(reader) + "isthmus-site: yard\r\n").code,
            403);
  EXPECT_THAT(ended(), Contains(Pair("UndoRevision", absl::StatusCode::kPermissionDenied)));
}

// A name that no header of gRPC can hold is nobody's, too.
TEST_F(GatewayTest, ANameThatNoSiteHasReachesNone) {
  Start();
  for (const char* site :
       {"yard", "", "%20", "default%20", "%C3%A4", "a%0Ab", "a%00b", "%5cx64efault"}) {
    const std::string query = std::string("?site=") + site;
    EXPECT_EQ(Call("SessionService/CreateSession" + query, R"({"robot": "alice"})").code, 404)
        << query;
    EXPECT_EQ(Get("/export/map.pcd" + query).code, 404) << query;
  }
  EXPECT_EQ(Call("MapService/GetMapInfo", "{}", "isthmus-site: \xe4\r\n").code, 404);
  EXPECT_EQ(ended().size(), failed().size());
  EXPECT_EQ(Call("MapService/GetMapInfo?site=default").code, 200);
}

TEST_F(GatewayTest, ThePeerIsTheClientOfHttp) {
  pipeline_.undo = 8;
  Start();
  http::Conversation conversation(address_);
  const std::string peer = "ipv4:127.0.0.1:" + std::to_string(conversation.port());
  Begin(&conversation, "EditService/UndoRevision", R"({"revision": "7"})",
        "X-Request-Id: mine-1\r\nisthmus-peer: ipv4:6.6.6.6:6\r\n");
  EXPECT_THAT(conversation.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  ASSERT_EQ(pipeline_.actors.size(), 1u);
  EXPECT_EQ(pipeline_.actors[0].from, peer);
  EXPECT_EQ(pipeline_.actors[0].request_id, "mine-1");
  EXPECT_EQ(Call("MapService/GetTransform", R"({"robotA": "a", "robotB": "b"})").code, 404);
  ASSERT_EQ(failed().size(), 1u);
  EXPECT_THAT(failed()[0].peer, StartsWith("ipv4:127.0.0.1:"));

  // A gRPC client cannot say that it is somebody else.
  rpc::Stubs stubs(grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
  const auto context = rpc::NewContext();
  context->AddMetadata("isthmus-peer", "ipv4:6.6.6.6:6");
  v1::UndoRevisionRequest request;
  request.set_revision(7);
  v1::UndoRevisionResponse response;
  EXPECT_GRPC_OK(stubs.edits->UndoRevision(context.get(), request, &response));
  ASSERT_EQ(pipeline_.actors.size(), 2u);
  EXPECT_THAT(pipeline_.actors[1].from, StartsWith("ipv4:127.0.0.1:"));
}

TEST_F(GatewayTest, AStreamEndsWithItsTokenAndSaysSo) {
  const std::string chief = NewToken("chief", AccessRole::kAdmin);
  Start();
  http::Conversation conversation(address_);
  Begin(&conversation, "EventService/WatchEvents", "{}", Bearer(chief));
  EXPECT_THAT(conversation.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  ASSERT_TRUE(tokens_->Revoke("chief").ok());
  const std::string rest = conversation.ReadUntil("}}\n");
  EXPECT_THAT(rest, HasSubstr(R"({"error":{"code":"UNAUTHENTICATED","message":")"));
}

TEST_F(GatewayTest, AStreamThatNobodyReadsAnyMoreIsCancelled) {
  Start();
  auto conversation = std::make_unique<http::Conversation>(address_);
  Begin(conversation.get(), "EventService/WatchEvents", "{}");
  EXPECT_THAT(conversation->ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  EXPECT_THAT(ended(), Not(Contains(Pair("WatchEvents", testing::_))));
  conversation.reset();
  AwaitEnded();
  EXPECT_THAT(ended(), Contains(Pair("WatchEvents", absl::StatusCode::kCancelled)));
}

TEST_F(GatewayTest, StreamsBeyondTheLimitAreToldToComeAgain) {
  Start();
  std::vector<std::unique_ptr<http::Conversation>> open;
  std::string last;
  while (open.size() < 150 && (last.empty() || last.find("200 OK") != std::string::npos)) {
    open.push_back(std::make_unique<http::Conversation>(address_));
    Begin(open.back().get(), "EventService/WatchEvents", "{}");
    last = open.back()->ReadUntil("\r\n\r\n");
  }
  EXPECT_THAT(last, AllOf(HasSubstr("503 "), HasSubstr("Retry-After: ")));
  EXPECT_EQ(Call("MapService/GetMapInfo").code, 200);  // Others are served.
}

TEST_F(GatewayTest, TheEndCutsStreamsOffAndCancelsTheirCalls) {
  Start();
  http::Conversation conversation(address_);
  Begin(&conversation, "EventService/WatchEvents", "{}");
  EXPECT_THAT(conversation.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  web_.reset();
  EXPECT_THAT(conversation.ReadAll(), Not(EndsWith("0\r\n\r\n")));
  // The server's own end would make it another status.
  AwaitEnded();
  EXPECT_THAT(ended(), Contains(Pair("WatchEvents", absl::StatusCode::kCancelled)));
}

}  // namespace
}  // namespace isthmus::web
