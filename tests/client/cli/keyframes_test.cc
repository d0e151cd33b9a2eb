// `isthmus push --keyframes` against a real server over a socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/console/push_scans.h"
#include "client/offline/embedded_server.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class KeyframesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = ScratchFolder();
    auto server = EmbeddedServer::Start({});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    const ProgramResult simulated =
        Isthmus("simulate --world museum --seed 3 --robots 1 --seconds 25 -o " + folder_);
    ASSERT_EQ(simulated.code, 0) << simulated.err;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string Drive() const { return folder_ + "/robot_0"; }
  json Push(const std::string& options) const {
    const ProgramResult result =
        Isthmus("push " + Drive() + " --json " + options + " --server " + Client().address());
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  client::Client& Client() const { return server_->client(); }
  std::vector<SubmapStatus> SubmapsOf(const std::string& robot) const {
    const auto submaps = Client().ListSubmaps(RobotId(robot));
    EXPECT_TRUE(submaps.ok()) << submaps.status();
    return *submaps;
  }

  std::unique_ptr<EmbeddedServer> server_;
  std::string folder_;
};

TEST_F(KeyframesTest, TheMapIsThatOfTheScansForATenthOfTheBytes) {
  const json streamed = Push("--robot streamed");
  const json kept = Push("--robot kept --keyframes");
  EXPECT_EQ(kept["processed"], streamed["processed"]);
  EXPECT_EQ(kept["scans"], streamed["scans"]);
  EXPECT_GT(kept["sent_bytes"], 0);
  EXPECT_LT(kept["sent_bytes"], streamed["sent_bytes"].get<double>() / 10);
  const auto of_scans = SubmapsOf("streamed"), of_keyframes = SubmapsOf("kept");
  ASSERT_GT(of_scans.size(), 1u);
  ASSERT_EQ(of_keyframes.size(), of_scans.size());
  for (size_t i = 0; i < of_scans.size(); ++i) {
    const SubmapInfo &a = of_scans[i].info, &b = of_keyframes[i].info;
    EXPECT_EQ(a.keyframe_count, b.keyframe_count);
    EXPECT_EQ(a.last_stamp_ns, b.last_stamp_ns);
    EXPECT_NEAR(static_cast<double>(b.point_count) / static_cast<double>(a.point_count), 1, 0.01);
    // Scans are rounded on their way, what stays here is not.
    EXPECT_LT((a.T_odom_submap.translation() - b.T_odom_submap.translation()).norm(), 0.02);
  }
  const auto session = Client().GetSession(SessionId(kept["session"].get<std::string>()));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->record.state, SessionState::kFinished);
}

TEST_F(KeyframesTest, TheSameAgainSendsNothing) {
  const json first = Push("--robot kept --keyframes");
  const json again = Push("--robot kept --keyframes");
  EXPECT_EQ(again["session"], first["session"]);
  EXPECT_EQ(again["sent_bytes"], 0);
  EXPECT_EQ(Client().ListSessions()->size(), 1u);
}

TEST_F(KeyframesTest, WhatWasInterruptedGoesOn) {
  auto robots = OpenRobots(Drive(), RecordingOptions());
  ASSERT_TRUE(robots.ok()) << robots.status();
  robots->front().robot = "kept";
  PushControl control;
  std::thread interrupter([&] {
    // NotFound before the session is there.
    for (size_t count = 0; count == 0; std::this_thread::yield()) {
      const auto submaps = Client().ListSubmaps(RobotId("kept"));
      if (submaps.ok()) count = submaps->size();
    }
    control.Stop();
  });
  // At a pace at which the drive is not over by then.
  const auto pushed =
      PushRobots(Client(), *std::move(robots), {.pace_hz = 100, .keyframes = true}, control);
  interrupter.join();
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  EXPECT_TRUE(pushed->front().is_interrupted);
  EXPECT_NE(pushed->front().state.record.state, SessionState::kFinished);

  const json rest = Push("--robot kept --keyframes");
  EXPECT_EQ(rest["session"], pushed->front().session.value());
  const json whole = Push("--robot whole --keyframes");
  EXPECT_LT(rest["sent_bytes"], whole["sent_bytes"]);
  EXPECT_EQ(SubmapsOf("kept").size(), SubmapsOf("whole").size());
}

TEST_F(KeyframesTest, ASpoolIsForScans) {
  const ProgramResult result =
      Isthmus("push " + Drive() + " --robot kept --keyframes --spool " + folder_ + "/spool");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--keyframes"));
}

}  // namespace
}  // namespace isthmus::cli
