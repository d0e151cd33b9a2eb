// Messages of `isthmus push` when a drive does not come into the map as a whole.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/push_scans.h"
#include "client/offline/embedded_server.h"
#include "client/readers/started_reader.h"
#include "core/codec/payload_builder.h"
#include "server/rpc/server.h"
#include "tests/client/cli/program.h"
#include "tests/core/codec/payloads.h"
#include "tests/faults/harness/proxy.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr uint64_t kScans = 60, kMeddledAt = 30;

int64_t Steadily(uint64_t scan) { return static_cast<int64_t>(scan) * 100'000'000; }
// As the clock was set back by a second in the middle: stamps come twice.
int64_t SetBack(uint64_t scan) {
  return 100'000'000'000 + Steadily(scan) - (scan > 20 ? 1'000'000'000 : 0);
}

// Scans of a room, in the middle of which something happens.
class MeddledScans final : public readers::ScanReader {
 public:
  explicit MeddledScans(std::function<void()> meddle, int64_t (*stamp)(uint64_t) = Steadily)
      : meddle_(std::move(meddle)), stamp_(stamp) {}

  absl::StatusOr<std::optional<readers::RecordedScan>> Next() override {
    if (read_ == kScans) return std::nullopt;
    if (++read_ == kMeddledAt) meddle_();
    readers::RecordedScan scan;
    scan.end_stamp_ns = stamp_(read_);
    scan.payload = codec::MakePayload(codec::RoomScan(), true, true);
    return scan;
  }

 private:
  const std::function<void()> meddle_;
  int64_t (*const stamp_)(uint64_t);
  uint64_t read_ = 0;
};

uint64_t FileSize(const std::string& path) { return std::filesystem::file_size(path); }

// The file of a spool that was written last.
std::string NewestFile(const std::string& spool) {
  std::string newest;
  for (const auto& file : std::filesystem::recursive_directory_iterator(spool)) {
    if (file.path().extension() == ".scans") newest = std::max(newest, file.path().string());
  }
  return newest;
}

class PushEndsTest : public testing::Test {
 protected:
  void SetUp() override {
    auto server = EmbeddedServer::Start({});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  // The status that the push ends with.
  absl::Status Push(std::function<void()> meddle, const PushOptions& options = {}) {
    PushControl control;
    return PushRobots(server_->client(), Robots(std::move(meddle)), options, control).status();
  }

  static std::vector<RobotScans> Robots(std::function<void()> meddle) {
    std::vector<RobotScans> robots(1);
    robots[0].robot = "alice";
    robots[0].sensor = "vlp16";
    robots[0].reader =
        std::make_unique<readers::StartedReader>(std::make_unique<MeddledScans>(std::move(meddle)));
    return robots;
  }

  // Until the server has some: the spool knows its session by then.
  void WaitForScans(const SessionId& id = SessionId("alice-1"), uint64_t scans = 1) {
    for (;;) {
      const auto session = server_->client().GetSession(id);
      if (session.ok() && session->last_sequence >= scans) return;
      std::this_thread::yield();
    }
  }

  std::unique_ptr<EmbeddedServer> server_;
};

TEST_F(PushEndsTest, OfASessionThatWasFinishedMeanwhileItTellsHowMuchThereIs) {
  const absl::Status status = Push([this] {
    const auto finished = server_->client().FinishSession(SessionId("alice-1"));
    EXPECT_TRUE(finished.ok()) << finished.status();
  });
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  const auto session = server_->client().GetSession(SessionId("alice-1"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_LT(session->last_sequence, kScans);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr(absl::StrCat("session alice-1 is finished, with ",
                                           session->last_sequence, " of the ")),
                    HasSubstr("isthmus session delete alice-1")));
}

TEST_F(PushEndsTest, WhatTheSpoolKeepsGoesIntoANewSessionIfAsked) {
  const std::string spool = ScratchFolder();
  const auto remove = [this] {
    WaitForScans();
    EXPECT_TRUE(server_->client().DeleteSession(SessionId("alice-1")).ok());
  };
  const absl::Status status = Push(remove, {.spool = spool});
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("--new-session"));
  const absl::Status again = Push([] {}, {.spool = spool});
  EXPECT_TRUE(absl::IsFailedPrecondition(again)) << again;
  EXPECT_TRUE(Push([] {}, {.spool = spool, .new_session = true}).ok());
  const auto session = server_->client().GetSession(SessionId("alice-2"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->record.state, SessionState::kFinished);
  EXPECT_GT(session->last_sequence, kScans - kMeddledAt);
  std::filesystem::remove_all(spool);
}

// Else a recording would be taken for whole in the session that has its end alone.
TEST_F(PushEndsTest, ASessionWithTheRestIsNotNotedForTheWholeRecording) {
  const std::string spool = ScratchFolder();
  const auto finish = [this] {
    WaitForScans();
    EXPECT_TRUE(server_->client().FinishSession(SessionId("alice-1")).ok());
  };
  const absl::Status status = Push(finish, {.spool = spool});
  ASSERT_TRUE(absl::IsFailedPrecondition(status)) << status;
  ASSERT_TRUE(Push([] {}, {.spool = spool, .new_session = true}).ok());
  const auto rest = server_->client().GetSession(SessionId("alice-2"));
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_LT(rest->last_sequence, kScans);
  EXPECT_FALSE(std::filesystem::exists(spool + "/pushed"));
  std::filesystem::remove_all(spool);
}

// Scans are neither lost nor pushed twice.
TEST_F(PushEndsTest, ASpoolIsGoneOnWithBehindItsLastScanThoughTheClockWasSetBack) {
  const std::string spool = ScratchFolder();
  const auto robots = [](const std::function<void()>& meddle) {
    std::vector<RobotScans> all = Robots([] {});
    all[0].reader =
        std::make_unique<readers::StartedReader>(std::make_unique<MeddledScans>(meddle, SetBack));
    all[0].read_again = [] { return std::make_unique<MeddledScans>([] {}, SetBack); };
    return all;
  };
  PushControl control;
  const auto first =
      PushRobots(server_->client(), robots([&] { control.Stop(); }), {.spool = spool}, control);
  ASSERT_TRUE(first.ok()) << first.status();
  PushControl unmoved;
  const auto second = PushRobots(server_->client(), robots([] {}), {.spool = spool}, unmoved);
  ASSERT_TRUE(second.ok()) << second.status();
  const PushSummary& summary = second->front();
  EXPECT_GE(summary.before, kMeddledAt - 1);
  EXPECT_EQ(summary.state.last_sequence, kScans);
  const ScanCounts& scans = summary.state.scans;
  EXPECT_EQ(scans.ok + scans.degenerate + scans.lost, kScans - 1);
  EXPECT_EQ(summary.state.scans.rejected, 1u);  // The first behind the step.
  std::filesystem::remove_all(spool);
}

// The server's scans tell what comes next, however much is left of the spool.
TEST_F(PushEndsTest, ADamagedSpoolNeitherLosesNorDoublesWhatTheServerHas) {
  const auto robots = [](const std::string& name, const std::function<void()>& meddle) {
    std::vector<RobotScans> all = Robots(meddle);
    all[0].robot = name;
    all[0].read_again = [] { return std::make_unique<MeddledScans>([] {}); };
    return all;
  };
  const std::map<std::string, std::function<void(const std::string&)>> damages = {
      {"cut", [](auto& path) { std::filesystem::resize_file(path, FileSize(path) / 3); }},
      {"emptied", [](auto& path) { std::filesystem::resize_file(path, 0); }},
      {"removed", [](auto& path) { std::filesystem::remove(path); }}};
  for (const auto& [name, damage] : damages) {
    SCOPED_TRACE(name);
    const std::string spool = ScratchFolder();
    PushControl control;
    const auto stop = [&, id = SessionId(name + "-1")] {
      WaitForScans(id, kMeddledAt / 2);
      control.Stop();
    };
    ASSERT_TRUE(PushRobots(server_->client(), robots(name, stop), {.spool = spool}, control).ok());
    damage(NewestFile(spool));
    PushControl unmoved;
    const auto all = PushRobots(server_->client(), robots(name, [] {}), {.spool = spool}, unmoved);
    ASSERT_TRUE(all.ok()) << all.status();
    const PushSummary& summary = all->front();
    EXPECT_GE(summary.before, kMeddledAt / 2);
    EXPECT_EQ(summary.before + summary.scans.pushed, kScans);
    EXPECT_EQ(summary.state.last_sequence, kScans);
    const ScanCounts& scans = summary.state.scans;
    EXPECT_EQ(scans.ok + scans.degenerate + scans.lost + scans.rejected, kScans);
    std::filesystem::remove_all(spool);
  }
}

TEST_F(PushEndsTest, ASpoolThatCannotBeUsedGivesFive) {
  const std::string folder = ScratchFolder();
  std::filesystem::create_directories(folder + "/locked/lock");
  std::filesystem::create_directories(folder + "/damaged/000001");
  std::ofstream(folder + "/damaged/000001/session") << "no session";
  std::ofstream(folder + "/file") << "no folder";
  for (const char* spool : {"/locked", "/damaged", "/file"}) {
    const absl::Status status = Push([] {}, {.spool = folder + spool});
    EXPECT_EQ(ServerExit(status), kInput) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("another")) << status;
  }
  std::filesystem::remove_all(folder);
}

// A folder without times counts from 0 as every other does: their stamps are the same.
TEST_F(PushEndsTest, ASpoolDoesNotTakeAnotherRecordingForItsOwn) {
  class Elsewhere final : public readers::ScanReader {
   public:
    explicit Elsewhere(int64_t begin_ns) : begin_ns_(begin_ns) {}
    absl::StatusOr<std::optional<readers::RecordedScan>> Next() override {
      auto scan = scans_.Next();
      if (!scan.ok() || !scan->has_value()) return scan;
      (*scan)->end_stamp_ns += begin_ns_;
      std::vector<ScanPoint> points = codec::RoomScan();
      for (ScanPoint& point : points) point.x *= 1.25F;
      (*scan)->payload = codec::MakePayload(points, true, true);
      return scan;
    }

   private:
    const int64_t begin_ns_;
    MeddledScans scans_{[] {}};
  };
  const auto robots = [](int64_t begin_ns) {
    std::vector<RobotScans> all = Robots([] {});
    all[0].reader = std::make_unique<readers::StartedReader>(std::make_unique<Elsewhere>(begin_ns));
    all[0].read_again = [begin_ns] { return std::make_unique<Elsewhere>(begin_ns); };
    return all;
  };
  const std::string spool = ScratchFolder();
  PushControl control;
  const auto stop = [&] {
    WaitForScans();
    control.Stop();
  };
  ASSERT_TRUE(PushRobots(server_->client(), Robots(stop), {.spool = spool}, control).ok());
  for (const int64_t begin_ns : {int64_t{0}, int64_t{-1'000'000'000'000}}) {
    PushControl unmoved;
    const absl::Status other =
        PushRobots(server_->client(), robots(begin_ns), {.spool = spool}, unmoved).status();
    EXPECT_TRUE(absl::IsFailedPrecondition(other)) << other;
    EXPECT_THAT(std::string(other.message()), HasSubstr("continue with alice-1"));
  }
  EXPECT_LE(server_->client().GetSession(SessionId("alice-1"))->last_sequence, kMeddledAt);
  std::filesystem::remove_all(spool);
}

// A program that is told to end while its server is gone ends at once: the spool keeps what is
// left.
TEST_F(PushEndsTest, AStopWithASpoolDoesNotWaitForAServerThatIsGone) {
  rpc::FakePipeline pipeline;
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = client::Client::Connect({.address = (*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  const std::string spool = ScratchFolder();
  PushControl control;
  const auto meddle = [&] {
    server->reset();
    EXPECT_TRUE(control.Stop());
  };
  const auto pushed = PushRobots(**client, Robots(meddle), {.spool = spool}, control);
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  EXPECT_TRUE(pushed->front().is_interrupted);
  EXPECT_EQ(pushed->front().scans.pushed, kMeddledAt - 1);
  EXPECT_FALSE(pushed->front().has_state);
  // The same command sends the rest of the spool.
  PushControl again;
  const auto rest =
      PushRobots(server_->client(), Robots([] {}), {.spool = spool, .new_session = true}, again);
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_GE(rest->front().scans.pushed, kScans - kMeddledAt + 1);
  std::filesystem::remove_all(spool);
}

TEST_F(PushEndsTest, WhatNoServerToldIsNotKnown) {
  const auto client = client::Client::Connect({.address = "127.0.0.1:1", .require_server = false});
  ASSERT_TRUE(client.ok()) << client.status();
  const std::string spool = ScratchFolder();
  PushControl control;
  const auto pushed =
      PushRobots(**client, Robots([&] { control.Stop(); }), {.spool = spool}, control);
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  const PushSummary& summary = pushed->front();
  EXPECT_EQ(summary.scans.pushed, kMeddledAt - 1);
  EXPECT_FALSE(summary.has_state);
  EXPECT_FALSE(summary.durable_sequence.has_value());
  EXPECT_FALSE(summary.mean_ms.has_value());
  std::filesystem::remove_all(spool);
}

// As one that was stopped: its connections stand, and nothing comes back.
TEST_F(PushEndsTest, WithASpoolAServerThatHangsIsWaitedFor) {
  const std::string spool = ScratchFolder();
  const std::string socket = spool + "/server";
  rpc::FakePipeline pipeline;
  rpc::ServerOptions options;
  options.listen = "unix:" + socket;
  const auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  faults::Proxy link(socket, 1);
  link.Stall(true);
  const ServerOptions at{.address = link.address(), .attempts = kPatientAttempts};
  const auto client = ConnectPatiently(at, /*may_begin_alone=*/true);
  ASSERT_TRUE(client.ok()) << client.status();
  PushControl control;
  const auto pushed =
      PushRobots(**client, Robots([&] { link.Stall(false); }), {.spool = spool + "/s"}, control);
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  EXPECT_EQ(pushed->front().used(), kScans);
  std::filesystem::remove_all(spool);
}

// The report of a push may get lost, or the push itself before it tells: the spool is empty then.
TEST_F(PushEndsTest, ARecordingThatIsWholeIsNotPushedOnceMore) {
  const auto robots = [](int64_t (*stamp)(uint64_t)) {
    std::vector<RobotScans> all = Robots([] {});
    all[0].reader =
        std::make_unique<readers::StartedReader>(std::make_unique<MeddledScans>([] {}, stamp));
    all[0].read_again = [stamp] { return std::make_unique<MeddledScans>([] {}, stamp); };
    return all;
  };
  const std::string spool = ScratchFolder();
  const auto push = [&](int64_t (*stamp)(uint64_t), const std::string& session, uint64_t scans) {
    PushControl control;
    const auto pushed = PushRobots(server_->client(), robots(stamp), {.spool = spool}, control);
    ASSERT_TRUE(pushed.ok()) << pushed.status();
    const PushSummary& summary = pushed->front();
    EXPECT_EQ(summary.session, SessionId(session));
    EXPECT_EQ(summary.scans.pushed, scans);
    EXPECT_EQ(summary.before + scans, kScans);
    EXPECT_TRUE(summary.has_state);
    EXPECT_EQ(summary.state.record.state, SessionState::kFinished);
  };
  push(Steadily, "alice-1", kScans);
  push(Steadily, "alice-1", 0);
  push(SetBack, "alice-2", kScans);  // Another recording.
  push(SetBack, "alice-2", 0);
  ASSERT_TRUE(server_->client().DeleteSession(SessionId("alice-2")).ok());
  push(SetBack, "alice-3", kScans);
  std::filesystem::remove_all(spool);
}

// Else the same command would find a spool that was begun, and push all into its session.
TEST_F(PushEndsTest, AStopBeforeTheServerConfirmsBeginsNoSession) {
  const std::string spool = ScratchFolder();
  const auto client = client::Client::Connect({.address = "127.0.0.1:1", .require_server = false});
  ASSERT_TRUE(client.ok()) << client.status();
  std::ofstream(spool + "/pushed") << "alice\nalice-1\n";
  PushControl control;
  std::vector<RobotScans> robots = Robots([] {});
  robots[0].read_again = [] { return std::make_unique<MeddledScans>([] {}); };
  std::thread stop([&] {
    while (!control.Stop()) std::this_thread::yield();
  });
  const auto pushed = PushRobots(**client, std::move(robots), {.spool = spool}, control);
  stop.join();
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  EXPECT_TRUE(pushed->front().is_interrupted);
  EXPECT_FALSE(std::filesystem::exists(spool + "/000001"));
  std::filesystem::remove_all(spool);
}

TEST_F(PushEndsTest, ASessionThatSomebodyFinishedTooEarlyIsNotTakenForTheWholeRecording) {
  const std::string spool = ScratchFolder();
  PushControl control;
  const auto stop = [&] {
    WaitForScans(SessionId("alice-1"), kMeddledAt - 1);
    control.Stop();
  };
  ASSERT_TRUE(PushRobots(server_->client(), Robots(stop), {.spool = spool}, control).ok());
  ASSERT_TRUE(server_->client().FinishSession(SessionId("alice-1")).ok());
  const absl::Status status = Push([] {}, {.spool = spool});
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("nothing tells that it has all"));
  EXPECT_TRUE(Push([] {}, {.spool = spool}).ok());
  EXPECT_EQ(server_->client().GetSession(SessionId("alice-2"))->last_sequence, kScans);
  std::filesystem::remove_all(spool);
}

// All scans are acknowledged by then.
TEST_F(PushEndsTest, WithoutFinishAServerThatHangsAtTheEndFailsNoPush) {
  class Hanging final : public rpc::FakePipeline {
   public:
    absl::StatusOr<SessionStatus> Get(const SessionId& session) const override {
      if (hangs) return absl::DeadlineExceededError("hangs");
      return rpc::FakePipeline::Get(session);
    }
    std::atomic<bool> hangs = false;
  } pipeline;
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  const auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = client::Client::Connect({.address = (*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  const auto hang = [&] {
    while (pipeline.submitted() == 0) std::this_thread::yield();
    pipeline.hangs = true;
  };
  const std::string spool = ScratchFolder();
  PushControl control;
  const auto pushed =
      PushRobots(**client, Robots(hang), {.finish = false, .spool = spool}, control);
  ASSERT_TRUE(pushed.ok()) << pushed.status();
  EXPECT_EQ(pushed->front().used(), kScans);
  EXPECT_FALSE(pushed->front().has_state);
  std::filesystem::remove_all(spool);
}

TEST_F(PushEndsTest, OfASessionThatWasDeletedMeanwhileItTellsThatItIsGone) {
  const absl::Status status = Push([this] {
    const absl::Status deleted = server_->client().DeleteSession(SessionId("alice-1"));
    EXPECT_TRUE(deleted.ok()) << deleted;
  });
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("session alice-1 was deleted"));
}

}  // namespace
}  // namespace isthmus::cli
