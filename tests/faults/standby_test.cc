// A server that stands by: quiet until it owns the map, and gone at once when it owns it no more.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "client/library/client.h"
#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/test_setup.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/server/main/child_process.h"
#include "tests/server/main/notify_socket.h"

namespace isthmus::faults {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class StandbyTest : public testing::Test {
 protected:
  StandbyTest() : database_(storage::PostgresServer::Start()) {
    std::ofstream(setup_.Path("config.yaml")) << "storage: {lease_s: 1}\n";
  }

  std::unique_ptr<ChildProcess> Launch(const std::string& name,
                                       const std::vector<std::string>& more = {"--standby"}) {
    std::vector<std::string> arguments = {
        "--data",   setup_.Path(name),          "--listen", "unix:" + setup_.Path(name + "-socket"),
        "--config", setup_.Path("config.yaml"), "--store",  database_->url()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::make_unique<ChildProcess>(setup_.get().server, arguments,
                                          setup_.Path(name + "-log"));
  }
  bool Answers(const std::string& name) const {
    client::ClientOptions options;
    options.address = "unix:" + setup_.Path(name + "-socket");
    options.backoff.max_attempts = 1;
    return client::Client::Connect(options).ok();
  }
  static size_t CountIn(const std::string& text, const std::string& words) {
    size_t count = 0;
    for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
      ++count;
    }
    return count;
  }

  const TestSetup setup_;
  std::unique_ptr<storage::PostgresServer> database_;
};

TEST_F(StandbyTest, IsReadyAndQuietAndEndsAtOnce) {
  const auto owner = Launch("owner", {});
  ASSERT_THAT(owner->ReadLine(), HasSubstr("listening on"));
  const NotifySocket manager(setup_.Path("notify"));
  const auto spare = Launch("spare");
  EXPECT_THAT(manager.Next(),
              StartsWith("READY=1\nSTATUS=Standing by: the schema isthmus is open in another "
                         "server, process " +
                         std::to_string(owner->pid()) + " on "));
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  EXPECT_EQ(manager.Next(), "WATCHDOG=1");
  EXPECT_TRUE(Answers("owner"));
  EXPECT_FALSE(Answers("spare"));
  spare->Signal(SIGHUP);
  spare->Signal(SIGTERM);
  EXPECT_EQ(spare->Wait(), 0) << spare->Errors();
  EXPECT_EQ(CountIn(spare->Errors(), "standing by"), 1u) << spare->Errors();
  EXPECT_THAT(spare->Errors(), HasSubstr("SIGHUP received"));
}

TEST_F(StandbyTest, ServesOnceTheOwnerStops) {
  const auto owner = Launch("owner", {});
  ASSERT_THAT(owner->ReadLine(), HasSubstr("listening on"));
  const NotifySocket manager(setup_.Path("notify"));
  const auto spare = Launch("spare");
  EXPECT_THAT(manager.Next(), StartsWith("READY=1\nSTATUS=Standing by"));
  owner->Signal(SIGTERM);
  EXPECT_THAT(spare->ReadLine(), HasSubstr("listening on"));
  EXPECT_EQ(owner->Wait(), 0);
  EXPECT_TRUE(Answers("spare"));
  std::string told = manager.Next();
  while (told == "WATCHDOG=1") told = manager.Next();
  EXPECT_THAT(told, StartsWith("READY=1\nSTATUS=Listening on "));
}

TEST_F(StandbyTest, WaitsForPostgresToo) {
  database_->Kill();
  const NotifySocket manager(setup_.Path("notify"));
  const auto spare = Launch("spare");
  EXPECT_THAT(manager.Next(), StartsWith("READY=1\nSTATUS=Standing by: connection to server"));
  ASSERT_TRUE(database_->StartAgain());
  EXPECT_THAT(spare->ReadLine(), HasSubstr("listening on")) << spare->Errors();
}

// With the setting or without it: a server that wakes up and has lost the map ends, so that a
// supervisor starts it anew.
TEST_F(StandbyTest, AnOwnerThatWasPausedEndsWithItsOwnExitCode) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--standby"}, std::vector<std::string>{}}) {
    const auto owner = Launch("owner", more);
    ASSERT_THAT(owner->ReadLine(), HasSubstr("listening on"));
    const auto spare = Launch("spare");
    owner->Signal(SIGSTOP);
    EXPECT_THAT(spare->ReadLine(), HasSubstr("listening on")) << spare->Errors();
    EXPECT_THAT(spare->Errors(), HasSubstr("has not renewed its lease in time"));
    owner->Signal(SIGCONT);
    EXPECT_EQ(owner->Wait(), 5) << owner->Errors();
    EXPECT_THAT(owner->Errors(), HasSubstr("This server ends at once"));
    EXPECT_TRUE(Answers("spare"));
    spare->Signal(SIGTERM);
    EXPECT_EQ(spare->Wait(), 0);
  }
}

TEST_F(StandbyTest, IsForMapsInADatabase) {
  ChildProcess server(setup_.get().server, {"--data", setup_.Path("map"), "--standby"},
                      setup_.Path("log"));
  EXPECT_EQ(server.Wait(), 2);
  EXPECT_THAT(server.Errors(), HasSubstr("--store"));
}

}  // namespace
}  // namespace isthmus::faults
