// Raw scans of sessions: kept before anything made of them is called durable.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "storage/archive/scan_reader.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/scans.h"

namespace isthmus::server {
namespace {

constexpr int64_t kDay = int64_t{86'400} * 1'000'000'000;

class ArchiveTest : public ::testing::Test {
 protected:
  ArchiveTest() : folder_(::testing::TempDir() + "isthmus_archive_" + std::to_string(getpid())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    options_.archive.mode = ArchiveMode::kFull;
    options_.archive.directory = folder_;
  }
  ~ArchiveTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::unique_ptr<Pipeline> Open() const { return OpenInMemory(options_); }
  SessionId Create(Pipeline& pipeline) const {
    return pipeline.sessions().Create({RobotId("alice"), "vlp16"})->record.id;
  }
  std::vector<ScanUpload> Read(const SessionId& session) const {
    std::vector<ScanUpload> scans;
    const auto reader = storage::ScanReader::Open(folder_, session);
    if (!reader.ok()) return scans;
    while (auto scan = (*reader)->Next().value()) scans.push_back(*std::move(scan));
    EXPECT_EQ((*reader)->damaged_count(), 0);
    return scans;
  }
  // From now on nothing can be written for a session.
  void Block(const SessionId& session) const {
    std::filesystem::remove_all(Folder(session));
    std::filesystem::create_directories(folder_ + "/scans");
    if (FILE* file = fopen(Folder(session).c_str(), "w")) fclose(file);
  }
  void Unblock(const SessionId& session) const { std::filesystem::remove(Folder(session)); }
  std::string Folder(const SessionId& session) const {
    return folder_ + "/scans/" + session.value();
  }

  const std::string folder_;
  PipelineOptions options_ = QuickOptions();
  const Drive drive_;
};

TEST_F(ArchiveTest, ScansThatDecodeAreKeptBitByBitWhateverBecomesOfThem) {
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  std::vector<ScanUpload> sent;
  for (int i = 0; i < 7; ++i) sent.push_back(drive_.Upload(i));
  sent[3].payload.data.resize(100);  // Is rejected, and nothing will ever be made of it.
  for (const ScanUpload& scan : sent)
    ASSERT_TRUE(pipeline->sessions().SubmitScan(session, scan).ok());
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, sent[2]).ok());  // A repeat.
  EXPECT_TRUE(absl::IsOutOfRange(pipeline->sessions().SubmitScan(session, drive_.Upload(20))));
  const auto status = pipeline->sessions().Finish(session);
  ASSERT_TRUE(status.ok());
  EXPECT_EQ(status->scans_rejected, 1u);
  EXPECT_EQ(status->archive_problem, "");
  sent.erase(sent.begin() + 3);
  const std::vector<ScanUpload> kept = Read(session);
  ASSERT_EQ(kept.size(), sent.size());
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].sequence, sent[i].sequence);
    EXPECT_EQ(kept[i].end_stamp_ns, sent[i].end_stamp_ns);
    EXPECT_TRUE(kept[i].payload.data == sent[i].payload.data);
  }
  pipeline->WaitUntilIdle();
  const SessionStatus counted = pipeline->sessions().Get(session).value();
  EXPECT_GT(counted.scan_bytes, 0u);
  EXPECT_GT(counted.map_bytes, 0u);
}

TEST_F(ArchiveTest, RoundedScansAreSmallAndClose) {
  options_.archive.mode = ArchiveMode::kRounded;
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  const ScanUpload sent = drive_.Upload(0);
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, sent).ok());
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  const std::vector<ScanUpload> kept = Read(session);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].payload.encoding, PayloadEncoding::kQuantized);
  EXPECT_EQ(kept[0].payload.resolution_m, options_.archive.resolution_m);
  EXPECT_LT(kept[0].payload.data.size(), sent.payload.data.size() / 2);
}

TEST_F(ArchiveTest, NothingIsKeptUnlessAskedFor) {
  options_.archive.mode = ArchiveMode::kOff;
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive_.Upload(0)).ok());
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/scans"));
}

TEST_F(ArchiveTest, DeletedSessionsTakeTheirScansAlong) {
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive_.Upload(0)).ok());
  ASSERT_TRUE(pipeline->sessions().Delete(session).ok());
  EXPECT_TRUE(Read(session).empty());
  EXPECT_TRUE(storage::ListArchivedSessions(folder_).empty());
}

// The store was lost, the scans were not: they are not mixed with others'.
TEST_F(ArchiveTest, ASessionIsNotGivenANameThatHasScans) {
  const SessionId lost = Create(*Open());
  {
    const auto pipeline = Open();
    ASSERT_EQ(Create(*pipeline), lost);
    ASSERT_TRUE(pipeline->sessions().SubmitScan(lost, drive_.Upload(0)).ok());
    ASSERT_TRUE(pipeline->sessions().Finish(lost).ok());
  }
  EXPECT_NE(Create(*Open()), lost);
  EXPECT_EQ(Read(lost).size(), 1u);
}

TEST_F(ArchiveTest, AScanThatCannotBeKeptIsNotTaken) {
  std::vector<std::string> problems;
  options_.on_problem = [&](const std::string& problem) { problems.push_back(problem); };
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  Block(session);
  for (int attempt = 0; attempt < 3; ++attempt) {
    const absl::Status refused = pipeline->sessions().SubmitScan(session, drive_.Upload(0));
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  }
  EXPECT_EQ(pipeline->sessions().Get(session)->last_sequence, 0u);
  EXPECT_NE(pipeline->sessions().Get(session)->archive_problem, "");
  EXPECT_EQ(problems.size(), 1u);
  Unblock(session);  // The disk is there again.
  ASSERT_TRUE(drive_.Submit(*pipeline, session, 0, 6).ok());
  const auto finished = pipeline->sessions().Finish(session);
  ASSERT_TRUE(finished.ok());
  EXPECT_EQ(finished->durable_sequence, 6u);
  EXPECT_EQ(finished->archive_problem, "");
  EXPECT_EQ(Read(session).size(), 6u);
}

TEST_F(ArchiveTest, WithoutBeingRequiredItSaysWhatIsMissing) {
  options_.archive.required = false;
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  Block(session);
  ASSERT_TRUE(drive_.Submit(*pipeline, session, 0, 3).ok());
  Unblock(session);
  ASSERT_TRUE(drive_.Submit(*pipeline, session, 3, 6).ok());
  const auto finished = pipeline->sessions().Finish(session);
  ASSERT_TRUE(finished.ok());
  EXPECT_EQ(finished->durable_sequence, 6u);
  EXPECT_EQ(finished->archive_problem.rfind("3 scans are missing", 0), 0u)
      << finished->archive_problem;
  EXPECT_EQ(Read(session).size(), 3u);
}

class QuotaTest : public ArchiveTest {
 protected:
  QuotaTest() { options_.submap.cut_scans = 100; }

  // A finished session of ten scans.
  SessionId Record(Pipeline& pipeline) const {
    const auto session = pipeline.sessions().Create({RobotId("alice"), "vlp16"});
    EXPECT_TRUE(session.ok()) << session.status();
    EXPECT_TRUE(drive_.Submit(pipeline, session->record.id, 0, 10).ok());
    EXPECT_TRUE(pipeline.sessions().Finish(session->record.id).ok());
    pipeline.WaitUntilIdle();
    return session->record.id;
  }
};

TEST_F(QuotaTest, ARobotAboveItsQuotaIsRefusedUntilThereIsRoom) {
  options_.retention.limits.quota_bytes = 1000;
  const auto pipeline = Open();
  const SessionId session = Record(*pipeline);  // A recording that was begun is finished.
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 10u);
  EXPECT_EQ(pipeline->sessions().Get(session)->quota_bytes, 1000u);
  const auto refused = pipeline->sessions().Create({RobotId("alice"), "vlp16"});
  EXPECT_TRUE(absl::IsResourceExhausted(refused.status())) << refused.status();
  EXPECT_TRUE(pipeline->sessions().Create({RobotId("bob"), "vlp16"}).ok());
  ASSERT_TRUE(pipeline->sessions().Delete(session).ok());
  pipeline->WaitUntilIdle();
  EXPECT_TRUE(pipeline->sessions().Create({RobotId("alice"), "vlp16"}).ok());
}

TEST_F(QuotaTest, ScansAreRefusedInTheMiddleOfASession) {
  options_.submap.cut_scans = 5;
  options_.retention.limits.quota_bytes = 1000;
  const auto pipeline = Open();
  const SessionId session = Create(*pipeline);
  absl::Status status;
  uint64_t sent = 0;
  while (sent < 200 &&
         (status = pipeline->sessions().SubmitScan(session, drive_.Upload(static_cast<int>(sent))))
             .ok()) {
    ++sent;
    pipeline->WaitUntilIdle();
  }
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_LE(sent, 10u);  // A submap is cut after five.
  const auto finished = pipeline->sessions().Finish(session);
  ASSERT_TRUE(finished.ok());
  EXPECT_EQ(finished->durable_sequence, sent);  // Nothing that was taken is lost.
}

TEST_F(QuotaTest, RawScansGoBeforeMapsAndTheOldestSessionBeforeOthers) {
  options_.retention.over_quota = OverQuota::kDropOldest;
  options_.archive.segment_bytes = 100'000;
  const auto open = [&] {
    auto pipeline =
        Pipeline::Open(options_, storage::OpenSqliteStore(folder_ + "/map").value()).value();
    pipeline->WaitUntilIdle();
    return pipeline;
  };
  uint64_t total = 0, maps = 0;
  std::vector<SessionStatus> before;
  {
    const auto pipeline = open();
    for (int i = 0; i < 3; ++i) Record(*pipeline);
  }
  before = open()->sessions().List();
  for (const SessionStatus& session : before) {
    ASSERT_GT(session.scan_bytes, 200'000u);
    ASSERT_GT(session.map_bytes, 1000u);
    total += session.map_bytes + session.scan_bytes;
    maps += session.map_bytes;
  }

  options_.retention.limits.quota_bytes = total - 1;
  std::vector<SessionStatus> now = open()->sessions().List();
  ASSERT_EQ(now.size(), 3u);
  EXPECT_LT(now[0].scan_bytes, before[0].scan_bytes);
  EXPECT_GT(now[0].scan_bytes, 0u);
  EXPECT_EQ(now[1].scan_bytes, before[1].scan_bytes);
  EXPECT_EQ(now[2].scan_bytes, before[2].scan_bytes);

  options_.retention.limits.quota_bytes = maps - 1;
  const auto pipeline = open();
  now = pipeline->sessions().List();
  ASSERT_EQ(now.size(), 2u);
  EXPECT_EQ(now[0].record.id, before[1].record.id);
  EXPECT_TRUE(storage::ListArchivedSessions(folder_).empty());
  const std::vector<RevisionInfo> revisions = pipeline->reader().ListRevisions(100).value();
  const std::string cause = before[0].record.id.value() + " deleted: robot alice";
  EXPECT_TRUE(std::any_of(revisions.begin(), revisions.end(), [&](const RevisionInfo& revision) {
    return revision.cause.find(cause) != std::string::npos;
  }));
}

TEST_F(QuotaTest, OldSessionsGoAtAStart) {
  const std::string database = folder_ + "/map";
  options_.retention.limits.max_age_days = 30;
  ManualClock clock(1'000'000'000'000'000'000);
  const auto open = [&] {
    return Pipeline::Open(options_, storage::OpenSqliteStore(database).value(), clock).value();
  };
  SessionId session;
  {
    const auto pipeline = open();
    session = Record(*pipeline);
    Create(*pipeline);  // Goes on.
  }
  clock.Advance(29 * kDay);
  EXPECT_EQ(open()->sessions().List().size(), 2u);
  clock.Advance(2 * kDay);
  const auto pipeline = open();
  EXPECT_TRUE(absl::IsNotFound(pipeline->sessions().Get(session).status()));
  EXPECT_EQ(pipeline->sessions().List().size(), 1u);
}

}  // namespace
}  // namespace isthmus::server
