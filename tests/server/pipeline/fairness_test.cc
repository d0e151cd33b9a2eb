// Fairness: one robot's share of the server, and its effect on others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <thread>

#include "core/clock.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

// A store in which a submap takes as long as it is told to.
class SlowSubmaps : public storage::ForwardingStore {
 public:
  explicit SlowSubmaps(std::shared_future<void> until)
      : ForwardingStore(storage::MakeMemoryStore()), until_(std::move(until)) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    if (!batch.submaps.empty()) {
      if (!writing_.exchange(true)) begun_.set_value();
      until_.wait();
    }
    return ForwardingStore::Write(batch);
  }
  std::future<void> begun() { return begun_.get_future(); }

 private:
  const std::shared_future<void> until_;
  std::atomic<bool> writing_ = false;
  std::promise<void> begun_;
};

Submap PointsInARow(const SessionId& session, int count) {
  Submap submap;
  submap.id = {session, 0};
  submap.keyframes = {{0, 1'000, Pose()}};
  for (int i = 0; i < count; ++i) submap.points.push_back({1.f, 0.1f * i, 0.f, 1.f, 0});
  return submap;
}

TEST(PipelineFairness, OpenSessionsAreBoundedByRobotAndInAll) {
  PipelineOptions options = QuickOptions();
  options.max_open_sessions_per_robot = 2;
  options.max_open_sessions = 3;
  auto pipeline = OpenInMemory(options);
  const SessionId first = Create(*pipeline);
  SessionRequest request{kAlice, "vlp16"};
  request.request_id = "the second";
  ASSERT_TRUE(pipeline->sessions().Create(request).ok());
  const absl::Status own = pipeline->sessions().Create({kAlice, "vlp16"}).status();
  EXPECT_EQ(own.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(own.message()), HasSubstr("max_open_sessions_per_robot"));
  // Asked for again it is the one that there is.
  EXPECT_TRUE(pipeline->sessions().Create(request).ok());
  Create(*pipeline, kBob);
  const absl::Status all = pipeline->sessions().Create({kBob, "vlp16"}).status();
  EXPECT_EQ(all.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(all.message()), HasSubstr("ingest.max_open_sessions"));
  // Finished ones do not count.
  ASSERT_TRUE(pipeline->sessions().Finish(first).ok());
  EXPECT_TRUE(pipeline->sessions().Create({kBob, "vlp16"}).ok());
}

// A client that opens sessions for nothing keeps nobody out for longer than a minute.
TEST(PipelineFairness, SessionsOfWhichNothingCameMakeRoom) {
  PipelineOptions options = QuickOptions();
  options.max_open_sessions = 3;
  ManualClock clock(0);
  auto pipeline = Pipeline::Open(options, storage::MakeMemoryStore(), clock).value();
  const Drive drive;
  const SessionId used = Create(*pipeline, RobotId("used"));
  ASSERT_TRUE(pipeline->sessions().SubmitScan(used, drive.Upload(0)).ok());
  pipeline->WaitUntilIdle();
  clock.Advance(1);
  const SessionId oldest = Create(*pipeline, RobotId("idle-1"));
  clock.Advance(1);
  const SessionId newer = Create(*pipeline, RobotId("idle-2"));
  clock.Advance(59'000'000'000);
  EXPECT_EQ(pipeline->sessions().Create({kAlice, "vlp16"}).status().code(),
            absl::StatusCode::kResourceExhausted);
  clock.Advance(2'000'000'000);
  EXPECT_TRUE(pipeline->sessions().Create({kAlice, "vlp16"}).ok());
  EXPECT_EQ(pipeline->sessions().Get(oldest)->record.state, SessionState::kFinished);
  EXPECT_EQ(pipeline->sessions().Get(newer)->record.state, SessionState::kActive);
  EXPECT_TRUE(pipeline->sessions().Create({kAlice, "vlp16"}).ok());
  EXPECT_EQ(pipeline->sessions().Get(newer)->record.state, SessionState::kFinished);
  // Robots keep sessions for which they have sent something.
  EXPECT_EQ(pipeline->sessions().Create({kAlice, "vlp16"}).status().code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(pipeline->sessions().Get(used)->record.state, SessionState::kActive);
}

TEST(PipelineFairness, ALargeUploadHoldsUpNobodyElse) {
  std::promise<void> until;
  auto store = std::make_unique<SlowSubmaps>(until.get_future().share());
  std::future<void> begun = store->begun();
  auto pipeline = Pipeline::Open(QuickOptions(), std::move(store)).value();
  const SessionId session = Create(*pipeline);
  std::thread upload(
      [&] { EXPECT_TRUE(pipeline->sessions().AddSubmap(PointsInARow(session, 200)).ok()); });
  begun.wait();
  // While that is under way others come and go; with one lock for all this waits for ever.
  const SessionId other = Create(*pipeline, kBob);
  EXPECT_TRUE(pipeline->sessions().Finish(other).ok());
  EXPECT_TRUE(pipeline->sessions().Delete(other).ok());
  until.set_value();
  upload.join();
  EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
}

TEST(PipelineFairness, MapsOfAFewPointsAreMatchedWithNone) {
  auto pipeline = OpenInMemory();
  std::vector<SessionId> sessions;
  for (int i = 0; i < 4; ++i) {
    sessions.push_back(Create(*pipeline, RobotId("robot" + std::to_string(i))));
    ASSERT_TRUE(
        pipeline->sessions().AddSubmap(PointsInARow(sessions.back(), i < 2 ? 20 : 200)).ok());
    ASSERT_TRUE(pipeline->sessions().Finish(sessions.back()).ok());
  }
  pipeline->WaitUntilIdle();
  const MatchGraph graph = pipeline->reader().GetMatchGraph();
  ASSERT_EQ(graph.matches.size(), 1u);  // The match of the two with more.
  EXPECT_EQ(graph.matches[0].match.a, sessions[2]);
  EXPECT_EQ(graph.matches[0].match.b, sessions[3]);
}

TEST(PipelineFairness, WhatASessionDoesWhenBehindOutlivesTheServer) {
  const std::string folder = ::testing::TempDir() + "isthmus_behind_" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  SessionRequest request{kAlice, "vlp16"};
  request.when_behind = WhenBehind::kKeepNewest;
  SessionId session;
  Drive drive;
  for (int start = 0; start < 2; ++start) {
    auto store = storage::OpenSqliteStore(folder, {});
    ASSERT_TRUE(store.ok()) << store.status();
    auto pipeline = Pipeline::Open(QuickOptions(), *std::move(store)).value();
    if (start == 0) session = pipeline->sessions().Create(request)->record.id;
    EXPECT_EQ(pipeline->sessions().Get(session)->record.when_behind, WhenBehind::kKeepNewest);
    // At any rate of scans: none waits, none is refused, each is used or skipped.
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(20 * start + i)).ok());
    }
    pipeline->WaitUntilIdle();
    const ScanCounts scans = pipeline->sessions().Get(session)->scans;
    EXPECT_EQ(scans.ok + scans.degenerate + scans.lost + scans.skipped, 20u * (start + 1));
    if (start == 0) continue;
    const ScanCounts finished = pipeline->sessions().Finish(session)->scans;
    EXPECT_EQ(finished, scans);
  }
  std::filesystem::remove_all(folder);
}

TEST(PipelineFairness, WhatWaitsIsLetGoOfWhenTheServerCannotWait) {
  auto pipeline = OpenInMemory();
  Drive drive;
  AckLog log;
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 10).ok());
  pipeline->StopTaking();
  EXPECT_EQ(pipeline->sessions().SubmitScan(session, drive.Upload(10)).code(),
            absl::StatusCode::kUnavailable);
  pipeline->Shutdown();
  // Acknowledged scans are stored; the rest was not acknowledged.
  uint64_t acknowledged = 0;
  for (const ScanAck& ack : log.Take()) acknowledged = std::max(acknowledged, ack.sequence);
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, acknowledged);
}

}  // namespace
}  // namespace isthmus::server
