#include "storage/upkeep/check_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/file_io.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class CheckStoreTest : public ::testing::Test {
 protected:
  static constexpr uint32_t kSubmaps = 6;

  void SetUp() override {
    const auto store = OpenSqliteStore(folder_.path());
    ASSERT_TRUE(store.ok()) << store.status();
    WriteBatch batch{
        .sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
        .checkpoints = {{SessionId("alice-1"), 9, 7, std::string(5000, 'c')}},
        .matching_progress = {{SessionId("alice-1"), 2}},
        .matches = {MakeMatch("alice-1", "bob-1")},
        .manual_decisions = {MakeManualDecision("alice-1", "bob-1")},
        .loops = {MakeLoop(1, "alice-1")},
        .anchors = {MakeAnchor("alice-1", 1)},
        .revision = MakeRevision(1),
        .events = {MakeEvent(EventKind::kSessionOpened, 1), MakeEvent(EventKind::kLoopClosed, 2),
                   MakeEvent(EventKind::kAnchorSet, 3)}};
    for (uint32_t i = 0; i < kSubmaps; ++i) {
      batch.submaps.push_back(MakeSubmap("alice-1", i, 3000));
      batch.trajectory.push_back({SessionId("alice-1"), MakeEntry(10 * i)});
    }
    ASSERT_TRUE((*store)->Write(batch).ok());
    for (uint32_t i = 0; i < 2; ++i) {
      const FeatureBlob blob = MakeFeatures({SessionId("alice-1"), i}, "k", std::string(9000, 'f'));
      ASSERT_TRUE((*store)->PutFeatures(blob).ok());
    }
  }

  void Execute(const std::string& sql) {
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok()) << database.status();
    const absl::Status status = (*database)->Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }
  StoreReport Check() {
    const auto report = CheckStore(folder_.path());
    EXPECT_TRUE(report.ok()) << report.status();
    return report.ok() ? *report : StoreReport();
  }
  void ExpectOneDamaged(const std::string& record) {
    const StoreReport report = Check();
    EXPECT_EQ(report.damaged_count, 1) << ToString(report);
    EXPECT_THAT(report.damaged, ElementsAre(Field(&DamagedRecord::record, record)));
  }

  TemporaryFolder folder_;
};

TEST_F(CheckStoreTest, FindsEventsThatAreMissing) {
  Execute("DELETE FROM events WHERE number = 2");
  ExpectOneDamaged("event 3");
  Execute("UPDATE events SET kind = 'WHATEVER', number = 2 WHERE number = 3");
  ExpectOneDamaged("event 2");
}

TEST_F(CheckStoreTest, FindsASoundFolderSoundAndCountsIt) {
  const std::string before = *io::ReadFile(folder_.database());
  const StoreReport report = Check();
  EXPECT_EQ(report.damaged_count, 0) << ToString(report);
  EXPECT_EQ(report.schema, Migrations().back().version);
  EXPECT_EQ(report.sessions, 2);
  EXPECT_EQ(report.submaps, kSubmaps);
  EXPECT_EQ(report.points, 3000 * kSubmaps);
  EXPECT_EQ(report.scans, kSubmaps);
  EXPECT_EQ(report.features, 2);
  EXPECT_EQ(report.matches, 1);
  EXPECT_EQ(report.loops, 1);
  EXPECT_EQ(report.checkpoints, 1);
  EXPECT_EQ(report.events, 3);
  EXPECT_EQ(report.revisions, 1);
  EXPECT_THAT(ToString(report), HasSubstr("sound"));
  EXPECT_EQ(*io::ReadFile(folder_.database()), before);
}

// Anywhere in the blobs: SQLite has no checksum of its own there.
TEST_F(CheckStoreTest, FindsEveryFlippedBitOfABlob) {
  const std::string sound = *io::ReadFile(folder_.database());
  const size_t begin = sound.find("ISM1");
  ASSERT_NE(begin, std::string::npos);
  for (size_t offset = 0; offset < 1000; offset += 37) {
    std::string bytes = sound;
    bytes[begin + offset] = static_cast<char>(bytes[begin + offset] ^ (1 << (offset % 8)));
    ASSERT_TRUE(io::WriteFile(folder_.database(), bytes).ok());
    const StoreReport report = Check();
    ASSERT_EQ(report.damaged_count, 1) << offset << "\n" << ToString(report);
    EXPECT_THAT(report.damaged[0].record, HasSubstr("submap alice-1/"));
    EXPECT_EQ(report.points, 3000 * (kSubmaps - 1));
  }
}

TEST_F(CheckStoreTest, NamesWhatIsDamagedOrMissing) {
  Execute("UPDATE features SET data = CAST('x' AS BLOB) WHERE submap = 2");
  ExpectOneDamaged("features 2");
  Execute("DELETE FROM features");
  Execute("UPDATE checkpoints SET data = CAST('x' AS BLOB)");
  ExpectOneDamaged("checkpoint of session alice-1");
  Execute("DELETE FROM checkpoints");
  Execute("UPDATE loops SET edges = CAST('IME1' AS BLOB)");
  ExpectOneDamaged("edges of loop closure 1");
  Execute("DELETE FROM loops");
  Execute("UPDATE trajectory SET T_odom_sensor = x'00' WHERE sequence = 20");
  ExpectOneDamaged("scan 20 of session alice-1");
  Execute("DELETE FROM trajectory");
  Execute("UPDATE submaps SET point_count = 2999 WHERE submap_index = 4");
  ExpectOneDamaged("submap alice-1/4");
  Execute("DELETE FROM submap_blobs WHERE submap = 5");  // A blob of submap 4.
  ExpectOneDamaged("submap alice-1/4");
  Execute("PRAGMA foreign_keys = OFF; DELETE FROM sessions WHERE id = 'bob-1'");
  const StoreReport report = Check();
  EXPECT_THAT(report.damaged,
              Contains(Field(&DamagedRecord::problem,
                             "a record of matches belongs to one of sessions that is not there")));
}

TEST_F(CheckStoreTest, NamesNumbersThatNoSubmapHas) {
  for (const std::string number : {"-1", "4294967296", "9223372036854775807"}) {
    Execute("UPDATE submaps SET submap_index = " + number +
            " WHERE submap_index NOT BETWEEN 0 AND 4");
    ExpectOneDamaged("a submap of alice-1");
  }
  Execute("UPDATE submaps SET submap_index = 5 WHERE submap_index > 4");
  Execute("UPDATE trajectory SET submap_index = -7 WHERE sequence = 20");
  ExpectOneDamaged("scan 20 of session alice-1");
  Execute("UPDATE trajectory SET submap_index = 2 WHERE sequence = 20");
  Execute("UPDATE matching_progress SET next_for_loops = -1");
  ExpectOneDamaged("matching progress of session alice-1");
}

TEST_F(CheckStoreTest, HalfACopyIsNoMap) {
  std::filesystem::rename(folder_.database(), folder_.database() + ".partial");
  const absl::Status half = CheckStore(folder_.path()).status();
  EXPECT_EQ(half.code(), StatusCode::kNotFound);
  EXPECT_THAT(std::string(half.message()), HasSubstr("isthmus copy again"));
  EXPECT_THAT(std::string(OpenSqliteStore(folder_.path()).status().message()),
              HasSubstr("isthmus copy again"));
}

// Cut between pages and within pages; the report says what is left.
TEST_F(CheckStoreTest, ATruncatedFileIsDamaged) {
  const std::string sound = *io::ReadFile(folder_.database());
  for (size_t size = 512; size < sound.size(); size += 8192 - 512) {
    ASSERT_TRUE(io::WriteFile(folder_.database(), sound.substr(0, size)).ok());
    const StoreReport report = Check();
    EXPECT_GT(report.damaged_count, 0) << size;
    EXPECT_THAT(ToString(report), HasSubstr("DAMAGED"));
    // SQLite takes a last page that is cut for whole, and the store finds out when it reads it.
    if (sound.size() - size < 4096) continue;
    EXPECT_EQ(OpenSqliteStore(folder_.path()).status().code(), StatusCode::kDataLoss) << size;
  }
}

TEST_F(CheckStoreTest, PagesOfNoiseAreDamage) {
  const std::string sound = *io::ReadFile(folder_.database());
  std::mt19937 random(7);
  for (size_t page = 4096; page < sound.size(); page += 4096) {
    std::string bytes = sound;
    for (size_t i = 0; i < 4096; ++i) bytes[page + i] = static_cast<char>(random());
    ASSERT_TRUE(io::WriteFile(folder_.database(), bytes).ok());
    EXPECT_GT(Check().damaged_count, 0) << "page " << page / 4096 + 1;
  }
}

// Records that were only in the log are gone; the state of the last checkpoint is there, and whole.
TEST_F(CheckStoreTest, AMissingLogIsAnOlderMap) {
  const std::string sound = *io::ReadFile(folder_.database());
  {
    const auto store = OpenSqliteStore(folder_.path());
    ASSERT_TRUE((*store)->Write({.submaps = {MakeSubmap("alice-1", 77)}}).ok());
    ASSERT_EQ(*io::ReadFile(folder_.database()), sound);
    // As copied from a machine that lost its power, but for the log.
    std::filesystem::create_directories(folder_.path() + "/copy");
    std::filesystem::copy(folder_.database(), folder_.path() + "/copy/isthmus.db");
  }
  const auto report = CheckStore(folder_.path() + "/copy");
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->damaged_count, 0) << ToString(*report);
  EXPECT_EQ(report->submaps, kSubmaps);
  EXPECT_TRUE(OpenSqliteStore(folder_.path() + "/copy").ok());
}

TEST_F(CheckStoreTest, ReadsTheLogToo) {
  auto database = SqliteConnection::Open(folder_.database());
  ASSERT_TRUE((*database)->SetCheckpointOnClose(false).ok());
  ASSERT_TRUE((*database)->Execute("UPDATE loops SET edges = CAST('IME1' AS BLOB)").ok());
  database->reset();
  const std::string log = *io::ReadFile(folder_.database() + "-wal");
  ExpectOneDamaged("edges of loop closure 1");
  EXPECT_EQ(*io::ReadFile(folder_.database() + "-wal"), log);
}

// A bit of each of the frames of three commits: the first two are damage, the last may be a power
// cut's doing. The commits before it are served.
TEST_F(CheckStoreTest, TellsADamagedLogFromATornEnd) {
  const std::string log = folder_.database() + "-wal";
  auto database = SqliteConnection::Open(folder_.database());
  ASSERT_TRUE((*database)->SetCheckpointOnClose(false).ok());
  std::vector<size_t> ends;
  for (int scan = 1; scan <= 3; ++scan) {
    ASSERT_TRUE((*database)
                    ->Execute("INSERT INTO trajectory SELECT session, " + std::to_string(scan) +
                              ", stamp_ns, submap_index, T_odom_sensor FROM trajectory LIMIT 1")
                    .ok());
    ends.push_back(io::ReadFile(log)->size());
  }
  database->reset();
  EXPECT_EQ(Check().damaged_count, 0);
  const std::string sound = *io::ReadFile(folder_.database());
  const std::string sound_log = *io::ReadFile(log);
  for (size_t commit = 0; commit < ends.size(); ++commit) {
    std::string bytes = sound_log;
    bytes[ends[commit] - 1000] = static_cast<char>(bytes[ends[commit] - 1000] ^ 16);
    ASSERT_TRUE(io::WriteFile(folder_.database(), sound).ok());
    ASSERT_TRUE(io::WriteFile(log, bytes).ok());
    if (commit + 1 < ends.size()) {
      ExpectOneDamaged("the write-ahead log");
    } else {
      EXPECT_EQ(Check().damaged_count, 0);
    }
    EXPECT_EQ(Check().scans, kSubmaps + commit);
    const auto store = OpenSqliteStore(folder_.path());
    ASSERT_TRUE(store.ok()) << store.status();
    EXPECT_EQ((*store)->GetTrajectory(SessionId("alice-1"))->size(), kSubmaps + commit);
  }
  std::string bytes = sound_log;
  bytes[9] = static_cast<char>(bytes[9] ^ 1);
  ASSERT_TRUE(io::WriteFile(folder_.database(), sound).ok());
  ASSERT_TRUE(io::WriteFile(log, bytes).ok());
  ExpectOneDamaged("the write-ahead log");
}

TEST_F(CheckStoreTest, SaysWhyItCannotRead) {
  EXPECT_EQ(CheckStore(folder_.path() + "/none").status().code(), StatusCode::kNotFound);
  {
    const auto store = OpenSqliteStore(folder_.path());
    const absl::Status used = CheckStore(folder_.path()).status();
    EXPECT_EQ(used.code(), StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(used.message()), HasSubstr("is in use by process"));
  }
  Execute("PRAGMA user_version = 99");
  const absl::Status newer = CheckStore(folder_.path()).status();
  EXPECT_EQ(newer.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(newer.message()), HasSubstr("use the newer program"));
}

}  // namespace
}  // namespace isthmus::storage
