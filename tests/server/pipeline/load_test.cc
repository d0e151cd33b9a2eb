// The load that the pipeline reports while robots wait, the store stalls, and all goes on.
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::server {
namespace {

constexpr int64_t kStart_ns = 1'790'000'000'000'000'000, kSecond_ns = 1'000'000'000;

TEST(PipelineLoad, SaysHowFarEachRobotsScansHaveCome) {
  Drive drive;
  ManualClock clock(kStart_ns);
  const auto faults = std::make_shared<storage::Faults>();
  auto pipeline =
      Pipeline::Open(QuickOptions(), storage::MakeFaultyStore(storage::MakeMemoryStore(), faults),
                     clock)
          .value();
  const SessionId session = Create(*pipeline);
  Create(*pipeline, kBob);
  for (int i = 0; i < 7; ++i) {
    clock.Advance(kSecond_ns);
    ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(i)).ok());
    pipeline->WaitUntilIdle();
  }
  clock.Advance(kSecond_ns);
  const ServerLoad load = pipeline->GetLoad();
  EXPECT_EQ(load.now_ns, kStart_ns + 8 * kSecond_ns);
  ASSERT_EQ(load.sessions.size(), 2u);
  const SessionLoad& alice = load.sessions[0];
  EXPECT_EQ(alice.session, session);
  EXPECT_EQ(alice.robot, kAlice);
  EXPECT_EQ(alice.waiting_scans, 0u);
  EXPECT_EQ(alice.waiting_bytes, 0u);
  EXPECT_EQ(alice.received_sequence, 7u);
  EXPECT_EQ(alice.acknowledged_sequence, 7u);
  EXPECT_EQ(alice.durable_sequence, 5u);  // A submap of five scans.
  EXPECT_EQ(alice.received_ns, kStart_ns + 7 * kSecond_ns);
  EXPECT_EQ(alice.ack_delay_ns, 0);
  EXPECT_EQ(alice.oldest_unacknowledged_ns, 0);
  EXPECT_EQ(alice.oldest_undurable_ns, kStart_ns + 6 * kSecond_ns);
  EXPECT_EQ(alice.scans_processed, 7u);
  EXPECT_EQ(alice.tracking, Tracking::kOk);
  EXPECT_EQ(alice.submaps, 1u);
  EXPECT_EQ(load.sessions[1].received_ns, 0);
  EXPECT_EQ(load.waiting_bytes, 0u);
  EXPECT_EQ(load.waiting_bytes_limit, QuickOptions().all_queues_bytes);
  EXPECT_EQ(load.session_scans_limit, QuickOptions().scan_queue);
  EXPECT_TRUE(load.matching.is_idle);
  EXPECT_EQ(load.matching.pairs, 0u);
  EXPECT_EQ(load.matching.submaps, 0u);
  EXPECT_FALSE(load.placement_waits || load.composition_waits || load.map_is_loading);
  EXPECT_EQ(load.revision, pipeline->GetMapInfo().revision);
  EXPECT_EQ(load.submaps, 1u);
  EXPECT_GT(load.submap_cache.bytes, 0u);
  EXPECT_GT(load.composed.bytes, 0u);
  EXPECT_EQ(load.disk.used_bytes(), 0u);  // All is in memory.
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  EXPECT_EQ(pipeline->GetLoad().sessions.size(), 1u);
}

TEST(PipelineLoad, IsToldWhileTheStoreStalls) {
  Drive drive;
  ManualClock clock(kStart_ns);
  const auto faults = std::make_shared<storage::Faults>();
  auto pipeline =
      Pipeline::Open(QuickOptions(), storage::MakeFaultyStore(storage::MakeMemoryStore(), faults),
                     clock)
          .value();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 4).ok());
  pipeline->WaitUntilIdle();
  faults->Stall();
  const int64_t writes = faults->writes();
  clock.Advance(kSecond_ns);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 4, 10).ok());
  while (faults->writes() == writes) std::this_thread::yield();  // The submap is being stored.
  // Robots do not wait for the disk before it is a whole submap behind.
  while (pipeline->GetLoad().sessions.at(0).acknowledged_sequence < 10) std::this_thread::yield();
  clock.Advance(kSecond_ns);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 10, 12).ok());
  clock.Advance(kSecond_ns);
  const SessionLoad stalled = pipeline->GetLoad().sessions.at(0);
  EXPECT_EQ(stalled.received_sequence, 12u);
  EXPECT_EQ(stalled.acknowledged_sequence, 10u);
  EXPECT_EQ(stalled.durable_sequence, 0u);
  EXPECT_EQ(stalled.waiting_scans, 2u);
  EXPECT_GT(stalled.waiting_bytes, 1000u);
  EXPECT_EQ(stalled.oldest_unacknowledged_ns, kStart_ns + 2 * kSecond_ns);
  EXPECT_EQ(stalled.oldest_undurable_ns, kStart_ns);
  EXPECT_EQ(pipeline->GetLoad().waiting_scans, 2u);
  EXPECT_GE(pipeline->GetLoad().waiting_bytes, stalled.waiting_bytes);
  faults->Resume();
  pipeline->WaitUntilIdle();
  const SessionLoad after = pipeline->GetLoad().sessions.at(0);
  EXPECT_EQ(after.acknowledged_sequence, 12u);
  EXPECT_EQ(after.ack_delay_ns, kSecond_ns);
  EXPECT_EQ(after.oldest_unacknowledged_ns, 0);
  EXPECT_EQ(after.oldest_undurable_ns, kStart_ns + 2 * kSecond_ns);
}

TEST(PipelineLoad, CountsScansThatAreNotUsed) {
  Drive drive;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(0)).ok());
  ScanUpload empty = drive.Upload(1);
  empty.payload.data.clear();
  empty.payload.width = 0;
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, empty).ok());
  pipeline->WaitUntilIdle();
  EXPECT_EQ(pipeline->GetLoad().sessions.at(0).scans_rejected, 1u);
  EXPECT_EQ(pipeline->GetLoad().sessions.at(0).scans_processed, 1u);
}

TEST(PipelineLoad, SaysWhatIsOnTheDisk) {
  const std::string folder = testing::TempDir() + "pipeline_load";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  PipelineOptions options = QuickOptions();
  options.archive.directory = folder;
  options.archive.mode = ArchiveMode::kRounded;
  Drive drive;
  auto pipeline = Pipeline::Open(options, storage::OpenSqliteStore(folder).value()).value();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 5).ok());
  pipeline->WaitUntilIdle();
  const ServerLoad load = pipeline->GetLoad();
  EXPECT_EQ(load.disk.database_bytes, std::filesystem::file_size(folder + "/isthmus.db"));
  EXPECT_EQ(load.disk.log_bytes, std::filesystem::file_size(folder + "/isthmus.db-wal"));
  EXPECT_GT(load.disk.log_bytes, 0u);
  EXPECT_GT(load.disk.scan_bytes, 1000u);
  EXPECT_EQ(load.sessions.at(0).scan_bytes, load.disk.scan_bytes);
  EXPECT_GT(load.disk.free_bytes, 0u);
  EXPECT_LT(load.disk.free_bytes, load.disk.total_bytes);
  EXPECT_EQ(load.disk.used_bytes(),
            load.disk.database_bytes + load.disk.log_bytes + load.disk.scan_bytes);
}

}  // namespace
}  // namespace isthmus::server
