// The event log through the client, over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/library/client.h"
#include "server/rpc/server.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::client {
namespace {

using testing::ElementsAre;

class ClientEventsTest : public testing::Test {
 protected:
  void SetUp() override {
    Serve();
    ClientOptions options;
    options.address = server_->address();
    options.backoff.max_attempts = 3;
    options.sleep = [](double) {};
    auto client = Client::Connect(options);
    ASSERT_TRUE(client.ok()) << client.status();
    client_ = *std::move(client);
  }

  void Serve() {
    rpc::ServerOptions options;
    options.listen = "127.0.0.1:" + std::to_string(port_);
    auto server = rpc::RpcServer::Start(&pipeline_, options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    port_ = server_->port();
  }
  void EndServer() {
    server_->Shutdown(std::chrono::milliseconds(0));
    server_.reset();
  }
  void Happens(EventKind kind) {
    Event event;
    event.kind = kind;
    event.text = "it happened";
    event.robot = RobotId("alice");
    pipeline_.events().Note(event);
  }

  rpc::FakePipeline pipeline_;
  int port_ = 0;
  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<Client> client_;
};

TEST_F(ClientEventsTest, AreListedAsTheyWereStored) {
  Event event;
  event.kind = EventKind::kAnchorSet;
  event.time_ns = 77;
  event.actor = {"chief", "ipv4:10.0.0.7:1", "12"};
  event.robot = RobotId("alice");
  event.session = SessionId("alice-1");
  event.text = "an anchor";
  pipeline_.events().Note(event);
  event.number = 1;
  const auto page = client_->ListEvents({.kinds = {EventKind::kAnchorSet}});
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(page->events, ElementsAre(event));
  EXPECT_EQ(page->newest, 1u);
  EXPECT_TRUE(client_->ListEvents({.robot = RobotId("bob")})->events.empty());
  EXPECT_TRUE(absl::IsOutOfRange(client_->ListEvents({.after = 2}).status()));
}

TEST_F(ClientEventsTest, AWatchOverARestartOfTheServerLosesAndRepeatsNothing) {
  Happens(EventKind::kRobotLost);
  Happens(EventKind::kRobotFound);
  std::vector<uint64_t> numbers;
  bool was_restarted = false;
  const absl::Status status = client_->WatchEvents({.after = 0}, [&](const EventPage& page) {
    for (const Event& event : page.events) numbers.push_back(event.number);
    if (numbers.size() == 2 && !was_restarted) {
      was_restarted = true;
      Happens(EventKind::kRobotLost);
      EndServer();
      Happens(EventKind::kRobotFound);
      Serve();
      Happens(EventKind::kRobotLost);
    }
    return numbers.size() < 5;
  });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_THAT(numbers, ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(ClientEventsTest, AWatchEndsWhenTheServerStaysAway) {
  const absl::Status status = client_->WatchEvents({}, [&](const EventPage&) {
    EndServer();
    return true;
  });
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
}

}  // namespace
}  // namespace isthmus::client
