#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <set>
#include <vector>

#include "server/jobs/job_key.h"
#include "server/threads/crash_journal.h"
#include "server/threads/limits.h"
#include "storage/memory_store.h"
#include "storage/records/submap_codec.h"
#include "storage/sqlite/sqlite.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/faulty_store.h"
#include "tests/storage/records.h"

namespace isthmus::server {
namespace {

class PipelineRestart : public testing::Test {
 protected:
  PipelineRestart()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~PipelineRestart() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<Pipeline> Open() {
    return Pipeline::Open(QuickOptions(), storage::OpenSqliteStore(folder_.string()).value())
        .value();
  }

  const std::filesystem::path folder_;
};

TEST_F(PipelineRestart, SessionsMapAndTrajectoriesAreThereAgain) {
  Drive drive;
  SessionId session;
  RobotTrajectory before;
  uint64_t points = 0;
  double travelled_m = 0;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 8).ok());
    ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
    pipeline->WaitUntilIdle();
    before = pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap).value();
    points = pipeline->reader().Map()->point_count(0);
    travelled_m = pipeline->sessions().Get(session)->travelled_m;
  }
  auto pipeline = Open();
  pipeline->WaitUntilIdle();
  const RobotTrajectory after =
      pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap).value();
  ASSERT_EQ(after.poses.size(), 8u);
  EXPECT_EQ(after.revision, before.revision);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_LT((after.poses[i].pose.translation() - before.poses[i].pose.translation()).norm(),
              1e-9);
  }
  // Points were rounded as the store does before anything was made of them.
  EXPECT_EQ(pipeline->reader().Map()->point_count(0), points);
  EXPECT_EQ(pipeline->sessions().Get(session)->record.state, SessionState::kFinished);
  EXPECT_GT(travelled_m, 0);
  EXPECT_NEAR(pipeline->sessions().Get(session)->travelled_m, travelled_m, 1e-6);
}

TEST_F(PipelineRestart, TheLastScansOfAFinishedSessionAreDurableThoughNoSubmapHoldsThem) {
  Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 8).ok());
    ScanUpload damaged = drive.Upload(8);
    damaged.payload.data.clear();
    ASSERT_TRUE(pipeline->sessions().SubmitScan(session, std::move(damaged)).ok());
    EXPECT_EQ(pipeline->sessions().Finish(session)->durable_sequence, 9u);
  }
  auto pipeline = Open();
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 9u);
  EXPECT_EQ(pipeline->sessions().Get(session)->last_sequence, 9u);
}

TEST_F(PipelineRestart, AnActiveSessionGoesOnInTheSameOdomFrame) {
  Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 42).ok());
    pipeline->Shutdown();
  }
  AckLog log;
  auto pipeline = Open();
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 42u);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(drive.Submit(*pipeline, session, 40, 60).ok());
  pipeline->WaitUntilIdle();
  const std::vector<ScanAck> acks = log.TakeScans();
  ASSERT_EQ(acks.size(), 20u);
  EXPECT_EQ(acks[1].outcome, ScanOutcome::kDuplicate);
  EXPECT_EQ(acks[2].outcome, ScanOutcome::kProcessed);
  const Pose T_sensor_odom = drive.simulator().Truth(0, 0).pose.Inverse();
  for (int i = 42; i < 60; ++i) {
    const ScanAck& ack = acks[i - 40];
    EXPECT_EQ(ack.tracking, Tracking::kOk);
    const Pose truth = T_sensor_odom * drive.simulator().Truth(0, i).pose;
    EXPECT_LT((ack.T_odom_sensor->translation() - truth.translation()).norm(), 0.1) << i;
  }
  EXPECT_EQ(
      pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kOdom)->poses.size(),
      60u);
}

// All that is stored of a session's scans, as bytes.
std::string Stored(const std::string& folder, const SessionId& session) {
  const auto store = storage::OpenSqliteStore(folder).value();
  std::string bytes;
  const auto add = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  const auto trajectory = store->GetTrajectory(session).value();
  for (const TrajectoryEntry& entry : trajectory) {
    add(entry.sequence);
    add(entry.stamp_ns);
    add(entry.submap_index);
    for (const double q : entry.T_odom_sensor.rotation().coeffs()) add(q);
    for (const double t : entry.T_odom_sensor.translation()) add(t);
  }
  const auto submaps = store->ListSubmaps(session).value();
  for (const SubmapInfo& info : submaps) {
    bytes += storage::EncodeSubmap(*store->GetSubmap(info.id).value(), 0.001).value();
    for (const double variance : info.drift_covariance.reshaped()) add(variance);
  }
  return bytes;
}

// As after kill -9: from a moment on nothing reaches the store, then the server is gone.
TEST_F(PipelineRestart, AKilledServerLeavesNoTrace) {
  constexpr int kScans = 33;
  const Drive drive;
  std::vector<std::string> stored;
  for (const std::vector<int>& kills : {std::vector<int>{}, {1, 8, 14, 15, 29}}) {
    const std::string folder = (folder_ / std::to_string(kills.size())).string();
    std::filesystem::create_directories(folder);
    SessionId session;
    std::unique_ptr<Pipeline> pipeline;
    std::shared_ptr<storage::Faults> faults;
    const auto open = [&] {
      faults = std::make_shared<storage::Faults>();
      pipeline =
          Pipeline::Open(QuickOptions(),
                         storage::MakeFaultyStore(storage::OpenSqliteStore(folder).value(), faults))
              .value();
    };
    open();
    const Pose mounted = Pose::FromXyzRpy(0.1, 0, 0.4, 0.01, -0.02, 0.5);
    session =
        pipeline->sessions().Create({RobotId("alice"), "vlp16", {}, mounted}).value().record.id;
    int next = 0;
    const auto send_until = [&](int end) {
      for (; next < end; ++next) {
        ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(next)).ok()) << next;
      }
    };
    for (const int kill : kills) {
      send_until(kill);
      faults->SetDiskFull(true);
      pipeline = nullptr;
      open();
      next = static_cast<int>(pipeline->sessions().Get(session)->durable_sequence);
      EXPECT_GE(next + 5 + 16, kill);  // A submap, and what was in the queue.
      EXPECT_GE(pipeline->sessions().Get(session)->last_sequence, static_cast<uint64_t>(next));
    }
    send_until(kScans);
    ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
    pipeline = nullptr;
    stored.push_back(Stored(folder, session));
  }
  EXPECT_GT(stored[0].size(), 100'000u);
  EXPECT_EQ(stored[0], stored[1]);
}

// State that only a checkpoint has is lost; the session, its odom frame and its numbers are not.
TEST_F(PipelineRestart, ADamagedCheckpointIsSaidAndGoneOnWithout) {
  const Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    for (int i = 0; i < 12; ++i)
      ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(i)).ok());
  }
  auto faults = std::make_shared<storage::Faults>();
  faults->Damage(session);
  std::vector<std::string> problems;
  PipelineOptions options = QuickOptions();
  options.on_problem = [&](const std::string& problem) { problems.push_back(problem); };
  auto store = storage::MakeFaultyStore(storage::OpenSqliteStore(folder_.string()).value(), faults);
  auto pipeline = Pipeline::Open(options, std::move(store)).value();
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("alice-1 was resumed from submaps"), std::string::npos) << problems[0];
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 12u);
  AckLog log;
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(drive.Submit(*pipeline, session, 12, 20).ok());
  pipeline->WaitUntilIdle();
  for (const ScanAck& ack : log.TakeScans()) EXPECT_EQ(ack.tracking, Tracking::kOk) << ack.sequence;
  EXPECT_NE(pipeline->sessions().Get(session)->input.find("resumed from submaps"),
            std::string::npos);
}

TEST_F(PipelineRestart, ASessionThatCannotGoOnIsSaidAndTheMapIsServed) {
  const Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 12).ok());
    pipeline->WaitUntilIdle();
  }
  {
    auto database = storage::SqliteConnection::Open((folder_ / "isthmus.db").string()).value();
    ASSERT_TRUE(database->Execute("UPDATE sessions SET sensor = 'nobody knows'").ok());
  }
  std::vector<std::string> problems;
  PipelineOptions options = QuickOptions();
  options.on_problem = [&](const std::string& problem) { problems.push_back(problem); };
  auto pipeline =
      Pipeline::Open(options, storage::OpenSqliteStore(folder_.string()).value()).value();
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("alice-1 cannot go on: unknown sensor"), std::string::npos)
      << problems[0];
  pipeline->WaitUntilIdle();
  EXPECT_GT(pipeline->reader().Map()->point_count(0), 0u);
  EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
}

// As many may wait as robots have sent in half a minute.
TEST_F(PipelineRestart, WhatWasNotSearchedForLoopsIsSearchedThen) {
  PipelineOptions options = QuickOptions();
  options.submap = {};
  options.loops.min_path_length_m = 15;
  const auto closing = [](const storage::MapStore& store) {
    std::set<uint32_t> submaps;
    const std::vector<LoopClosure> loops = store.ListLoops().value();
    for (const LoopClosure& loop : loops) submaps.insert(loop.submap_b);
    return submaps;
  };
  auto memory = storage::MakeMemoryStore();
  storage::MapStore& store = *memory;
  const auto pipeline = Pipeline::Open(options, std::move(memory)).value();
  const SessionId session = Create(*pipeline, kAlice);
  const Drive drive(1, 4);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 600).ok());
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  pipeline->WaitUntilIdle();
  const std::set<uint32_t> all = closing(store);
  ASSERT_FALSE(all.empty());
  storage::WriteBatch batch;
  batch.sessions = {store.GetSession(session).value()};
  const std::vector<SubmapInfo> submaps = store.ListSubmaps(session).value();
  for (const SubmapInfo& submap : submaps) {
    batch.submaps.push_back(store.GetSubmap(submap.id).value());
  }
  // Searched for loops: none, and the last and so all.
  for (const bool was_searched : {false, true}) {
    auto next_memory = storage::MakeMemoryStore();
    storage::MapStore& next_store = *next_memory;
    ASSERT_TRUE(next_store.Write(batch).ok());
    if (was_searched) {
      const std::vector<storage::MatchingProgress> searched = store.ListMatchingProgress().value();
      ASSERT_EQ(searched.size(), 1u);
      EXPECT_EQ(searched[0].next_for_loops, batch.submaps.back()->id.index + 1);
      ASSERT_TRUE(next_store.Write({.matching_progress = searched}).ok());
    }
    const auto next = Pipeline::Open(options, std::move(next_memory)).value();
    next->WaitUntilIdle();
    EXPECT_EQ(closing(next_store), was_searched ? std::set<uint32_t>() : all);
  }
  // One that two processes ended at is left out, and is not taken for searched by what follows it;
  // after a process that was stopped in order it is tried once more.
  options.crash_journal = (folder_ / "journal").string();
  const SubmapId ended_at{session, *all.begin()};
  for (int i = 0; i < kMaxCrashes; ++i) {
    CrashJournal(options.crash_journal).BeginTask(ToText(LoopKey{ended_at}));
  }
  for (const bool is_left_out : {true, false}) {
    auto file = storage::OpenSqliteStore(folder_.string()).value();
    ASSERT_EQ(file->Write(batch).ok(), is_left_out);  // The second time it is there.
    storage::MapStore& stored = *file;
    const auto next = Pipeline::Open(options, std::move(file)).value();
    next->WaitUntilIdle();
    EXPECT_EQ(closing(stored).contains(ended_at.index), !is_left_out);
    EXPECT_EQ(stored.ListMatchingProgress().value().at(0).next_for_loops,
              is_left_out ? ended_at.index : batch.submaps.back()->id.index + 1);
  }
}

// Somebody may still be at work on the map of the deleted one.
TEST_F(PipelineRestart, TheNumberOfASessionThatWasThereIsNotGivenAgain) {
  {
    auto pipeline = Open();
    for (int i = 1; i <= 3; ++i) Create(*pipeline, kAlice);
  }
  auto pipeline = Open();
  ASSERT_TRUE(pipeline->sessions().Delete(SessionId("alice-1")).ok());
  ASSERT_TRUE(pipeline->sessions().Delete(SessionId("alice-3")).ok());
  EXPECT_EQ(Create(*pipeline, kAlice).value(), "alice-4");
}

// The server serves the submap as it is stored, not as it came.
TEST_F(PipelineRestart, AnUploadedSubmapIsTheSameAfterwards) {
  const auto served = [](Pipeline& pipeline) {
    pipeline.WaitUntilIdle();
    std::set<std::array<float, 3>> points;
    const absl::Status status = pipeline.reader().Map()->Read({}, 1000, [&](const auto& chunk) {
      for (const MapPoint& p : chunk) points.insert({p.x, p.y, p.z});
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
    return points;
  };
  std::set<std::array<float, 3>> before;
  {
    auto pipeline = Open();
    Create(*pipeline, kAlice);
    ASSERT_TRUE(pipeline->sessions().AddSubmap(*storage::MakeSubmap("alice-1", 0)).ok());
    before = served(*pipeline);
  }
  EXPECT_FALSE(before.empty());
  EXPECT_EQ(served(*Open()), before);
}

// Others, who keep what they have read of it, must not take the next for it, either.
TEST_F(PipelineRestart, NorIsThatOfOneThatWasDeletedBefore) {
  {
    auto pipeline = Open();
    for (int i = 1; i <= 3; ++i) Create(*pipeline, kAlice);
    ASSERT_TRUE(pipeline->sessions().Delete(SessionId("alice-3")).ok());
    ASSERT_TRUE(pipeline->sessions().Delete(SessionId("alice-1")).ok());
  }
  auto pipeline = Open();
  EXPECT_EQ(Create(*pipeline, kAlice).value(), "alice-4");
}

}  // namespace
}  // namespace isthmus::server
