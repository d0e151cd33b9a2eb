// The promise that only a store on disk makes: to survive.
#include "storage/sqlite/sqlite_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/io/file_io.h"
#include "storage/sql/rows.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"
#include "storage/upkeep/check_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

class SqliteStoreTest : public ::testing::Test {
 protected:
  std::unique_ptr<MapStore> Open(const SqliteOptions& options = {}) {
    auto store = OpenSqliteStore(folder_.path(), options);
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }
  absl::Status OpenStatus() { return OpenSqliteStore(folder_.path()).status(); }

  // Runs SQL on the database while no store has it.
  void Execute(const std::string& sql) {
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok()) << database.status();
    const absl::Status status = (*database)->Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }

  // Runs SQL as if values of any type were allowed in the table: as damage or another program
  // leaves it.
  void ExecuteUnchecked(const std::string& table, const std::string& sql) {
    std::string schema;
    {
      auto database = SqliteConnection::Open(folder_.database());
      ASSERT_TRUE(database.ok()) << database.status();
      Statement read = (*database)->Prepare("SELECT sql FROM sqlite_schema WHERE name = ?");
      ASSERT_TRUE(*read.Bind(table).Step());
      schema = read.Text(0);
    }
    Execute(
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(replace(replace(sql, "
        "'STRICT,', ''), 'STRICT', ''), 'NOT NULL', '') WHERE name = '" +
        table + "'");
    Execute(sql);
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok()) << database.status();
    ASSERT_TRUE((*database)->Execute("PRAGMA writable_schema = ON").ok());
    Statement put = (*database)->Prepare("UPDATE sqlite_schema SET sql = ? WHERE name = ?");
    ASSERT_TRUE(put.Bind(schema).Bind(table).Run().ok());
  }

  static WriteBatch FullBatch() {
    return {.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
            .trajectory = {{SessionId("alice-1"), MakeEntry(1)}},
            .submaps = {MakeSubmap("alice-1", 0), MakeSubmap("alice-1", 1)},
            .matches = {MakeMatch("alice-1", "bob-1")},
            .revision = MakeRevision(1)};
  }
  static void ExpectFullBatch(const MapStore& store) {
    EXPECT_EQ(store.ListSessions()->size(), 2u);
    EXPECT_EQ(store.GetTrajectory(alice_)->size(), 1u);
    EXPECT_EQ((*store.GetSubmap({alice_, 1}))->points.size(), 600u);
    EXPECT_EQ(store.ListMatches()->size(), 1u);
    EXPECT_EQ(store.LatestRevision()->placements.size(), 2u);
  }

  inline static const SessionId alice_{"alice-1"};
  TemporaryFolder folder_;
};

TEST_F(SqliteStoreTest, ReopensWithEverything) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  ExpectFullBatch(*Open());
}

TEST_F(SqliteStoreTest, SurvivesTheDeathOfTheProcess) {
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto store = OpenSqliteStore(folder_.path());
    const bool good = store.ok() && (*store)->Write(FullBatch()).ok();
    if (write(pipe_ends[1], good ? "+" : "-", 1) != 1) _exit(1);
    pause();  // Killed with everything open.
    _exit(0);
  }
  char outcome = '?';
  ASSERT_EQ(read(pipe_ends[0], &outcome, 1), 1);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(pipe_ends[0]);
  close(pipe_ends[1]);
  ASSERT_EQ(outcome, '+');
  ExpectFullBatch(*Open());
}

// Killed at any moment of a stream of batches: each is there as a whole or not at all.
TEST_F(SqliteStoreTest, NeverKeepsHalfABatch) {
  for (int round = 0; round < 5; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const uint32_t first = Open()->ListSubmaps(std::nullopt)->size();
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      SqliteOptions options;
      options.sync_every_commit = false;
      auto store = OpenSqliteStore(folder_.path(), options);
      if (!store.ok()) _exit(1);
      for (uint32_t i = first;; ++i) {
        const WriteBatch batch{.sessions = {MakeSession("alice-1")},
                               .trajectory = {{alice_, MakeEntry(i)}},
                               .submaps = {MakeSubmap("alice-1", i)}};
        if (!(*store)->Write(batch).ok()) _exit(1);
        if (write(pipe_ends[1], "+", 1) != 1) _exit(1);
      }
    }
    char acknowledged[8];
    const int wanted = round + 2;
    for (int got = 0; got < wanted; ++got) ASSERT_EQ(read(pipe_ends[0], acknowledged, 1), 1);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(pipe_ends[0]);
    close(pipe_ends[1]);
    const auto store = Open();
    const auto submaps = store->ListSubmaps(alice_);
    EXPECT_GE(submaps->size(), first + wanted);
    EXPECT_EQ(store->GetTrajectory(alice_)->size(), submaps->size());
    for (const SubmapInfo& info : *submaps) EXPECT_TRUE(store->GetSubmap(info.id).ok());
  }
}

TEST_F(SqliteStoreTest, BelongsToOneProcess) {
  const auto store = Open();
  const absl::Status second = OpenStatus();
  EXPECT_EQ(second.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.message()), HasSubstr(folder_.path()));
  EXPECT_THAT(std::string(second.message()), HasSubstr(std::to_string(getpid())));
}

TEST_F(SqliteStoreTest, BelongsToOneProcessWithoutItsLockFileToo) {
  const auto store = Open();
  std::filesystem::remove(folder_.path() + "/isthmus.lock");
  const absl::Status second = OpenStatus();
  EXPECT_EQ(second.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.message()), HasSubstr("in use by process"));
}

TEST_F(SqliteStoreTest, RefusesWhatAnotherProgramAddedToTheSchema) {
  const std::vector<std::pair<std::string, std::string>> foreign = {
      {"trigger evil",
       "CREATE TRIGGER evil AFTER INSERT ON sessions BEGIN DELETE FROM sessions; END"},
      {"view endless",
       "CREATE VIEW endless AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
       "SELECT i FROM n"},
      {"table photos", "CREATE TABLE photos (name TEXT)"},
      {"index more", "CREATE INDEX more ON sessions (robot)"},
      {"table events", "ALTER TABLE events ADD COLUMN more TEXT"}};
  for (const auto& [name, sql] : foreign) {
    std::filesystem::remove_all(folder_.path());
    Open();
    Execute(sql);
    const absl::Status status = OpenStatus();
    EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition) << name;
    EXPECT_THAT(std::string(status.message()), HasSubstr("the " + name));
    EXPECT_EQ(CheckStore(folder_.path()).status().code(), StatusCode::kFailedPrecondition) << name;
  }
}

// A view in place of a table of ours would be run by whoever counts its rows.
TEST_F(SqliteStoreTest, RefusesAViewInPlaceOfATable) {
  Open();
  Execute("DROP TABLE events");
  Execute(
      "CREATE VIEW events AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
      "SELECT i FROM n");
  EXPECT_THAT(std::string(OpenStatus().message()), HasSubstr("the view events"));
  EXPECT_THAT(std::string(CheckStore(folder_.path()).status().message()),
              HasSubstr("the view events"));
}

TEST_F(SqliteStoreTest, StatisticsAndAVacuumAreNobodys) {
  Open();
  Execute("ANALYZE; VACUUM");
  EXPECT_TRUE(OpenStatus().ok()) << OpenStatus();
}

TEST_F(SqliteStoreTest, RefusesANewerSchemaAndLeavesItAlone) {
  Open();
  Execute("PRAGMA user_version = 99");
  const auto before = io::ReadFile(folder_.database());
  const absl::Status status = OpenStatus();
  EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("schema 99"));
  EXPECT_EQ(*io::ReadFile(folder_.database()), *before);
  for (const char* beside : {"-wal", "-shm"}) {
    EXPECT_FALSE(std::filesystem::exists(folder_.database() + beside)) << beside;
  }
}

// As a newer program that was killed leaves it: its version is in the log only.
TEST_F(SqliteStoreTest, LeavesTheLogOfANewerSchemaAlone) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  auto newer = SqliteConnection::Open(folder_.database());
  ASSERT_TRUE((*newer)->SetCheckpointOnClose(false).ok());
  ASSERT_TRUE((*newer)->Execute("PRAGMA user_version = 99").ok());
  newer->reset();
  const std::string log = folder_.database() + "-wal";
  const std::string database_before = *io::ReadFile(folder_.database());
  const std::string log_before = *io::ReadFile(log);
  ASSERT_FALSE(log_before.empty());
  const absl::Status status = OpenStatus();
  EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("use the newer program"));
  EXPECT_EQ(*io::ReadFile(folder_.database()), database_before);
  EXPECT_EQ(*io::ReadFile(log), log_before);
  // It was no more than the number.
  Execute("PRAGMA user_version = " + std::to_string(Migrations().back().version));
  ExpectFullBatch(*Open());
}

TEST_F(SqliteStoreTest, RefusesTheDatabaseOfAnother) {
  std::filesystem::create_directories(folder_.path());
  Execute("CREATE TABLE photos (name TEXT)");
  EXPECT_EQ(OpenStatus().code(), StatusCode::kFailedPrecondition);
  ASSERT_TRUE(io::WriteFile(folder_.database(), std::string(5000, 'x')).ok());
  EXPECT_EQ(OpenStatus().code(), StatusCode::kDataLoss);
}

TEST_F(SqliteStoreTest, RefusesAFolderThatIsNone) {
  ASSERT_TRUE(io::WriteFile(folder_.path(), "a file").ok());
  EXPECT_FALSE(OpenStatus().ok());
  EXPECT_FALSE(OpenSqliteStore("/proc/isthmus").ok());
  EXPECT_EQ(OpenSqliteStore(folder_.path(), {.resolution_m = 0}).status().code(),
            StatusCode::kInvalidArgument);
}

TEST_F(SqliteStoreTest, NamesADamagedSubmapAndServesTheOthers) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  // One bit on the disk, within the blob of alice-1/1, the second that begins with its magic.
  std::string bytes = *io::ReadFile(folder_.database());
  const size_t one = bytes.find("ISM1");
  ASSERT_NE(one, std::string::npos);
  const size_t other = bytes.find("ISM1", one + 1);
  ASSERT_NE(other, std::string::npos);
  // Pages fill from their ends: the store has to say what lies where.
  bytes[other + 100] = static_cast<char>(bytes[other + 100] ^ 4);
  ASSERT_TRUE(io::WriteFile(folder_.database(), bytes).ok());
  const auto store = Open();
  int damaged = 0;
  for (uint32_t index : {0u, 1u}) {
    const auto submap = store->GetSubmap({alice_, index});
    if (submap.ok()) continue;
    ++damaged;
    EXPECT_EQ(submap.status().code(), StatusCode::kDataLoss) << submap.status();
    EXPECT_THAT(std::string(submap.status().message()),
                HasSubstr("alice-1/" + std::to_string(index)));
  }
  EXPECT_EQ(damaged, 1);
  EXPECT_EQ(store->ListSubmaps(alice_)->size(), 2u);
  EXPECT_EQ(store->GetTrajectory(alice_)->size(), 1u);
}

// One page of noise, each in turn. Most hold points: they cost their submap and no other.
TEST_F(SqliteStoreTest, APageOfNoiseCostsLittle) {
  constexpr uint32_t kSubmaps = 8;
  WriteBatch batch{.sessions = {MakeSession("alice-1")}};
  for (uint32_t i = 0; i < kSubmaps; ++i) batch.submaps.push_back(MakeSubmap("alice-1", i, 3000));
  ASSERT_TRUE(Open({.sync_every_commit = false})->Write(batch).ok());
  const std::string sound = *io::ReadFile(folder_.database());
  std::mt19937 random(3);
  int pages = 0, listed = 0, one_lost = 0;
  for (size_t page = 4096; page < sound.size(); page += 4096, ++pages) {
    std::string bytes = sound;
    for (size_t i = 0; i < 4096; ++i) bytes[page + i] = static_cast<char>(random());
    ASSERT_TRUE(io::WriteFile(folder_.database(), bytes).ok());
    const auto store = OpenSqliteStore(folder_.path(), {.sync_every_commit = false});
    if (!store.ok()) continue;
    const auto infos = (*store)->ListSubmaps(alice_);
    if (!infos.ok()) continue;
    ++listed;
    uint32_t lost = 0;
    for (const SubmapInfo& info : *infos) {
      const absl::Status status = (*store)->GetSubmap(info.id).status();
      if (status.ok()) continue;
      ++lost;
      EXPECT_EQ(status.code(), StatusCode::kDataLoss) << status;
      EXPECT_THAT(std::string(status.message()), HasSubstr("submap " + ToString(info.id)));
    }
    one_lost += lost == 1 ? 1 : 0;
  }
  EXPECT_GT(listed, pages * 3 / 4);
  EXPECT_GT(one_lost, pages / 4);
}

TEST_F(SqliteStoreTest, ASubmapWithoutItsPointsIsDamaged) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  Execute("DELETE FROM submap_blobs WHERE submap = 1");
  const auto store = Open();
  EXPECT_EQ(store->ListSubmaps(alice_)->size(), 2u);
  EXPECT_EQ(store->GetSubmap({alice_, 0}).status().code(), StatusCode::kDataLoss);
  EXPECT_TRUE(store->GetSubmap({alice_, 1}).ok());
}

TEST_F(SqliteStoreTest, NoticesDamagedFeaturesAndSwappedBlobs) {
  auto store = Open();
  ASSERT_TRUE(store->Write(FullBatch()).ok());
  ASSERT_TRUE(store->Write({.submaps = {MakeSubmap("alice-1", 2, 50)}}).ok());
  ASSERT_TRUE(store->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", "features")).ok());
  store.reset();
  Execute("UPDATE features SET data = CAST('featured' AS BLOB)");
  Execute(
      "UPDATE submap_blobs SET data = (SELECT b.data FROM submap_blobs b JOIN submaps s "
      "ON s.key = b.submap WHERE s.submap_index = 2)");
  store = Open();
  EXPECT_EQ(store->GetFeatures({alice_, 0}, "fpfh").status().code(), StatusCode::kDataLoss);
  EXPECT_EQ(store->GetSubmap({alice_, 0}).status().code(), StatusCode::kDataLoss);
  EXPECT_TRUE(store->GetSubmap({alice_, 2}).ok());
}

TEST_F(SqliteStoreTest, AValueOfAnotherTypeIsNamedAndNotReadAsNothing) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  const auto names = [&](const absl::Status& status, const char* column) {
    EXPECT_EQ(status.code(), StatusCode::kDataLoss) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(column));
    EXPECT_THAT(std::string(status.message()), HasSubstr("isthmus-server --check"));
  };
  ExecuteUnchecked("matches", "UPDATE matches SET inliers = 'many'");
  names(Open()->ListMatches().status(), "matches.inliers is TEXT");
  EXPECT_EQ(Open()->ListSessions()->size(), 2u) << "what is sound is read";
  ExecuteUnchecked("trajectory", "UPDATE trajectory SET T_odom_sensor = 7");
  names(Open()->GetTrajectory(alice_).status(), "trajectory.T_odom_sensor is INTEGER");
  Execute("UPDATE submaps SET submap_index = 4294967296 WHERE submap_index = 1");
  names(Open()->ListSubmaps(alice_).status(), "4294967296");
  ExecuteUnchecked("sessions", "UPDATE sessions SET robot = NULL WHERE id = 'alice-1'");
  names(Open()->ListSessions().status(), "sessions.robot is NULL");
  names(Open()->GetSession(alice_).status(), "sessions.robot is NULL");
  EXPECT_TRUE(Open()->GetSession(SessionId("bob-1")).ok());
}

TEST_F(SqliteStoreTest, RecordsOfOneThatIsNotThereAreSaid) {
  ASSERT_TRUE(Open()->Write(FullBatch()).ok());
  std::vector<std::string> problems;
  const SqliteOptions options = {.on_problem = [&](const auto& text) { problems.push_back(text); }};
  Open(options);
  EXPECT_TRUE(problems.empty());
  Execute("UPDATE submaps SET session = 999 WHERE submap_index = 1");
  Open(options);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], HasSubstr("1 records of submaps belong to one that is not there"));
}

TEST_F(SqliteStoreTest, DamagedEdgesCostNoOtherRecord) {
  WriteBatch batch = FullBatch();
  batch.sessions.push_back(MakeSession("carol-1"));
  batch.matches.push_back(MakeMatch("alice-1", "carol-1"));
  batch.loops = {MakeLoop(1, "alice-1"), MakeLoop(2, "alice-1")};
  ASSERT_TRUE(Open()->Write(batch).ok());
  for (const char* where : {"matches SET edges = CAST(substr(edges, 1, 100) AS BLOB) WHERE b = 2",
                            "loops SET edges = CAST('IME1 no edges' AS BLOB) WHERE id = 1"}) {
    Execute(std::string("UPDATE ") + where);
  }
  const auto store = Open();
  const auto matches = store->ListMatches();
  ASSERT_TRUE(matches.ok()) << matches.status();
  ASSERT_EQ(matches->size(), 2u);
  EXPECT_EQ(matches->at(0).b, SessionId("bob-1"));
  EXPECT_EQ(matches->at(0).reason, MatchReason::kCycle);
  EXPECT_TRUE(matches->at(0).edges.empty());
  EXPECT_EQ(matches->at(1).edges.size(), 2u);
  const auto loops = store->ListLoops();
  ASSERT_TRUE(loops.ok()) << loops.status();
  ASSERT_EQ(loops->size(), 1u);
  EXPECT_EQ(loops->at(0).id, 2u);
}

// No file of this process can grow beyond `bytes` while it lives: a full disk without a disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_;
};

TEST_F(SqliteStoreTest, SaysWhenTheDiskIsFullAndGoesOnWhenItIsNot) {
  const auto store = Open();
  ASSERT_TRUE(store->Write(FullBatch()).ok());
  WriteBatch large{.trajectory = {{alice_, MakeEntry(2)}},
                   .submaps = {MakeSubmap("alice-1", 2), MakeSubmap("alice-1", 3, 200'000)},
                   .revision = MakeRevision(2)};
  absl::Status full, small;
  {
    const FileSizeLimit limit(600'000);
    full = store->Write(large);
    small = store->Write({.trajectory = {{alice_, MakeEntry(3)}}});
  }
  EXPECT_EQ(full.code(), StatusCode::kResourceExhausted) << full;
  EXPECT_TRUE(small.ok()) << small;
  EXPECT_EQ(store->ListSubmaps(alice_)->size(), 2u);
  EXPECT_EQ(store->GetTrajectory(alice_)->size(), 2u);
  EXPECT_EQ(store->LatestRevision()->revision, 1);
  ASSERT_TRUE(store->Write(large).ok());
  EXPECT_EQ((*store->GetSubmap({alice_, 3}))->points.size(), 200'000u);
  EXPECT_EQ(store->LatestRevision()->revision, 2);
}

// The log's index has no room, of which SQLite says only that reading or writing failed.
TEST_F(SqliteStoreTest, SaysAtTheStartThatTheDiskIsFull) {
  Open();
  absl::Status full;
  {
    const FileSizeLimit limit(8192);
    full = OpenStatus();
  }
  EXPECT_EQ(full.code(), StatusCode::kResourceExhausted) << full;
  EXPECT_EQ(full.message(), folder_.database() + ": its disk is full; free some space on it");
  EXPECT_TRUE(OpenStatus().ok()) << OpenStatus();
}

TEST_F(SqliteStoreTest, ForgetsOldRevisions) {
  auto store = Open({.sync_every_commit = false});
  for (int64_t i = 1; i <= kRevisionsKept + 5; ++i) {
    ASSERT_TRUE(store->Write({.revision = MakeRevision(2 * i)}).ok());
  }
  store.reset();
  auto database = SqliteConnection::Open(folder_.database());
  Statement count = (*database)->Prepare(
      "SELECT count(*), min(revision), (SELECT count(*) FROM placements) FROM revisions");
  ASSERT_TRUE(*count.Step());
  EXPECT_EQ(count.Int(0), kRevisionsKept);
  EXPECT_EQ(count.Int(1), 12);
  EXPECT_EQ(count.Int(2), 2);  // Placements of the latest revision.
}

TEST_F(SqliteStoreTest, KeepsIntegrityThroughDeletions) {
  auto store = Open();
  ASSERT_TRUE(store->Write(FullBatch()).ok());
  ASSERT_TRUE(store->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", "x")).ok());
  ASSERT_TRUE(store
                  ->Write({.matching_progress = {{alice_, 1}},
                           .loops = {MakeLoop(1, "alice-1")},
                           .anchors = {MakeAnchor("alice-1", 1)}})
                  .ok());
  const absl::Status deleted = store->DeleteSession(alice_);
  ASSERT_TRUE(deleted.ok()) << deleted;
  store.reset();
  auto database = SqliteConnection::Open(folder_.database());
  for (const char* table :
       {"trajectory", "submaps", "submap_blobs", "features", "matches", "match_stages",
        "match_rivals", "loops", "anchors", "matching_progress"}) {
    Statement count = (*database)->Prepare(std::string("SELECT count(*) FROM ") + table);
    ASSERT_TRUE(*count.Step());
    EXPECT_EQ(count.Int(0), 0) << table;
  }
  Statement check = (*database)->Prepare("PRAGMA integrity_check");
  ASSERT_TRUE(*check.Step());
  EXPECT_EQ(check.Text(0), "ok");
}

TEST_F(SqliteStoreTest, SaysWhoseFileItIs) {
  Open();
  auto database = SqliteConnection::Open(folder_.database());
  Statement id = (*database)->Prepare("PRAGMA application_id");
  ASSERT_TRUE(*id.Step());
  EXPECT_EQ(id.Int(0), kApplicationId);
  Statement mode = (*database)->Prepare("PRAGMA journal_mode");
  ASSERT_TRUE(*mode.Step());
  EXPECT_EQ(mode.Text(0), "wal");
}

TEST(SqliteCheckpoint, SurvivesAndTellsItsNumbersWhereItIsDamaged) {
  const Checkpoint checkpoint{SessionId("alice-1"), 10, 7, std::string(100'000, 'c')};
  const TemporaryFolder folder;
  const SessionId alice("alice-1");
  {
    auto store = OpenSqliteStore(folder.path());
    ASSERT_TRUE(store.ok()) << store.status();
    ASSERT_TRUE(
        (*store)->Write({.sessions = {MakeSession("alice-1")}, .checkpoints = {checkpoint}}).ok());
  }
  EXPECT_EQ((*OpenSqliteStore(folder.path()))->GetCheckpoint(alice)->data, checkpoint.data);
  {
    auto database = SqliteConnection::Open(folder.database());
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE((*database)->Execute("UPDATE checkpoints SET data = zeroblob(5000)").ok());
  }
  const auto damaged = (*OpenSqliteStore(folder.path()))->GetCheckpoint(alice);
  ASSERT_TRUE(damaged.ok()) << damaged.status();
  EXPECT_EQ(damaged->sequence, 10u);
  EXPECT_EQ(damaged->durable_sequence, 7u);
  EXPECT_FALSE(damaged->data.has_value());
}

}  // namespace
}  // namespace isthmus::storage
