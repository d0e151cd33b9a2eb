// isthmus log, against a server whose log is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "server/rpc/server.h"
#include "tests/client/cli/program.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

class LogCommandTest : public testing::Test {
 protected:
  LogCommandTest() {
    rpc::ServerOptions options;
    options.listen = "127.0.0.1:0";
    server_ = *rpc::RpcServer::Start(&pipeline_, options);
  }

  void Happens(EventKind kind, const std::string& robot, const std::string& text) {
    Event event;
    event.kind = kind;
    event.time_ns = 1'772'359'438'000'000'000;  // 2026-03-01T10:03:58Z
    event.robot = RobotId(robot);
    event.text = text;
    pipeline_.events().Note(event);
  }
  ProgramResult Log(const std::string& arguments) {
    return Isthmus("log --server " + server_->address() + " " + arguments);
  }

  rpc::FakePipeline pipeline_;
  std::unique_ptr<rpc::RpcServer> server_;
};

TEST_F(LogCommandTest, ALineAnEventTheNewestLast) {
  Event decided;
  decided.kind = EventKind::kMatchDecided;
  decided.time_ns = 1'772'359'438'000'000'000;
  decided.actor = {"chief", "ipv4:10.0.0.7:4711", "812"};
  decided.text = "match alice-1 ~ bob-1 by hand: REJECT";
  pipeline_.events().Note(decided);
  Happens(EventKind::kRobotLost, "alice", "session alice-1 is lost");
  const ProgramResult result = Log("");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out,
            "#1 2026-03-01T10:03:58Z MATCH_DECIDED    match alice-1 ~ bob-1 by hand: REJECT (by "
            "chief, from ipv4:10.0.0.7:4711, request 812)\n"
            "#2 2026-03-01T10:03:58Z ROBOT_LOST       session alice-1 is lost\n");
}

TEST_F(LogCommandTest, NoTextForgesALineOrReachesTheTerminal) {
  Happens(EventKind::kMatchDecided, "", "note: x\n#9 2026-03-01T10:03:58Z \x1b[31mall is well");
  const ProgramResult result = Log("");
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 1);
  EXPECT_THAT(result.out, HasSubstr("x\\x0a#9"));
  EXPECT_THAT(result.out, Not(HasSubstr("\x1b")));
}

TEST_F(LogCommandTest, ShowsWhatIsAskedFor) {
  for (int k = 0; k < 30; ++k) Happens(EventKind::kLoopClosed, "alice", "a loop");
  Happens(EventKind::kRobotLost, "bob", "lost");
  EXPECT_THAT(Log("").out, testing::StartsWith("#12 "));
  EXPECT_THAT(Log("--limit 2").out, testing::StartsWith("#30 "));
  EXPECT_THAT(Log("--since '#3' --limit 1").out, testing::StartsWith("#3 "));
  const std::string all = Log("--since 2026-03-01").out;
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 31);
  EXPECT_EQ(Log("--since 2026-03-02").out, "");
  EXPECT_EQ(Log("--since 2026-03-01T10:03:59Z").out, "");
  EXPECT_THAT(Log("--kind robot_lost").out, testing::StartsWith("#31 "));
  EXPECT_THAT(Log("--robot bob").out, testing::StartsWith("#31 "));
  const auto document = nlohmann::json::parse(Log("--robot bob --json").out);
  EXPECT_EQ(document["version"], 2);
  EXPECT_EQ(document["newest"], 31);
  ASSERT_EQ(document["events"].size(), 1u);
  EXPECT_EQ(document["events"][0]["kind"], "ROBOT_LOST");
  EXPECT_EQ(document["events"][0]["robot"], "bob");
}

TEST_F(LogCommandTest, WhatMakesNoSenseIsSaid) {
  const ProgramResult kind = Log("--kind NONSENSE");
  EXPECT_EQ(kind.code, 2);
  EXPECT_THAT(kind.err, HasSubstr("ROBOT_LOST"));
  const ProgramResult since = Log("--since yesterday");
  EXPECT_EQ(since.code, 2);
  EXPECT_THAT(since.err, HasSubstr("12h"));
  EXPECT_NE(Log("--since '#99'").code, 0);
}

// `head` has seen enough after three lines, and ends the command with the next.
TEST_F(LogCommandTest, FollowGoesOn) {
  Happens(EventKind::kRobotLost, "alice", "first");
  std::atomic<bool> has_ended = false;
  std::thread happening([&] {
    for (int k = 0; !has_ended; ++k) {
      Happens(EventKind::kRobotFound, "alice", "more");
      std::this_thread::yield();
    }
  });
  const ProgramResult result =
      Isthmus("log --follow --since '#1' --json --server " + server_->address() + " | head -n 3");
  has_ended = true;
  happening.join();
  std::istringstream lines(result.out);
  std::string line;
  for (uint64_t number = 1; number <= 3; ++number) {
    ASSERT_TRUE(std::getline(lines, line)) << result.err;
    EXPECT_EQ(nlohmann::json::parse(line)["number"], number);
  }
}

}  // namespace
}  // namespace isthmus::cli
