// Writers at the same time share commits, and nothing else.
#include "storage/sql/group_commit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <thread>

#include "storage/sqlite/sqlite.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

constexpr int kWriters = 8;

void InThreads(const std::function<void(int)>& run) {
  std::vector<std::thread> threads;
  for (int writer = 0; writer < kWriters; ++writer) threads.emplace_back(run, writer);
  for (std::thread& thread : threads) thread.join();
}

SessionId SessionOf(int writer) { return SessionId("robot-" + std::to_string(writer)); }

class GroupCommitTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_.path()); }

  std::unique_ptr<MapStore> OpenStore() {
    auto store = OpenSqliteStore(folder_.path());
    EXPECT_TRUE(store.ok()) << store.status();
    return *std::move(store);
  }
  std::unique_ptr<SqliteConnection> OpenTable() {
    auto database = SqliteConnection::Open(folder_.database());
    EXPECT_TRUE((*database)->Execute("PRAGMA journal_mode = WAL").ok());
    EXPECT_TRUE((*database)->Execute("CREATE TABLE IF NOT EXISTS t (a INTEGER UNIQUE)").ok());
    return *std::move(database);
  }
  static absl::Status Insert(Connection& database, int64_t value) {
    return database.Prepare("INSERT INTO t VALUES (?)").Bind(value).Run();
  }
  std::vector<int64_t> Values() {
    const auto database = SqliteConnection::Open(folder_.database());
    Statement row = (*database)->Prepare("SELECT a FROM t ORDER BY rowid");
    std::vector<int64_t> values;
    while (*row.Step()) values.push_back(row.Int(0));
    return values;
  }

  TemporaryFolder folder_;
};

// A third of the batches break a rule, some at their beginning and some at their end.
TEST_F(GroupCommitTest, LosesAndDoublesNothingAmongFailures) {
  constexpr uint32_t kBatches = 60;
  auto store = OpenStore();
  std::atomic<int> surprises = 0;
  InThreads([&](int writer) {
    const SessionId id = SessionOf(writer);
    if (!store->Write({.sessions = {MakeSession(id.value())}}).ok()) ++surprises;
    for (uint32_t i = 0; i < kBatches; ++i) {
      WriteBatch batch{.trajectory = {{id, MakeEntry(i)}},
                       .submaps = {MakeSubmap(id.value(), i, 20)}};
      const bool is_bad = i % 3 == 2;
      if (i % 6 == 2) batch.submaps.push_back(MakeSubmap(id.value(), i - 1, 20));
      if (i % 6 == 5) batch.revision = MakeRevision(0);
      if (store->Write(batch).ok() == is_bad) ++surprises;
      // Acknowledged writes are there for their caller at once.
      if (store->GetSubmap({id, i}).ok() == is_bad) ++surprises;
      if (!is_bad && !store->PutFeatures(MakeFeatures({id, i}, "k", id.value())).ok()) ++surprises;
    }
  });
  EXPECT_EQ(surprises, 0);
  store = nullptr;
  store = OpenStore();
  for (int writer = 0; writer < kWriters; ++writer) {
    const SessionId id = SessionOf(writer);
    const auto submaps = store->ListSubmaps(id);
    const auto trajectory = store->GetTrajectory(id);
    ASSERT_EQ(submaps->size(), kBatches * 2 / 3);
    ASSERT_EQ(trajectory->size(), kBatches * 2 / 3);
    for (uint32_t i = 0; i < submaps->size(); ++i) {
      const uint32_t index = i / 2 * 3 + i % 2;
      EXPECT_EQ((*submaps)[i].id.index, index);
      EXPECT_EQ((*trajectory)[i].sequence, index);
      EXPECT_EQ(*store->GetFeatures({id, index}, "k"), id.value());
    }
  }
  EXPECT_EQ(store->LatestRevision()->revision, 0);
}

// The same submap from everybody at once: one is told that it is stored, all others that it was.
TEST_F(GroupCommitTest, AcknowledgesOneOfManyEqual) {
  const auto store = OpenStore();
  ASSERT_TRUE(store->Write({.sessions = {MakeSession("alice-1")}}).ok());
  for (uint32_t i = 0; i < 20; ++i) {
    std::atomic<int> stored = 0, repeated = 0;
    InThreads([&](int) {
      const absl::Status status = store->Write({.submaps = {MakeSubmap("alice-1", i, 20)}});
      if (status.ok()) ++stored;
      if (absl::IsAlreadyExists(status)) ++repeated;
    });
    EXPECT_EQ(stored, 1);
    EXPECT_EQ(repeated, kWriters - 1);
  }
}

TEST_F(GroupCommitTest, KeepsTheOrderOfEachCaller) {
  GroupCommit commit(OpenTable());
  InThreads([&](int writer) {
    for (int i = 0; i < 50; ++i) {
      const int64_t value = 1000 * writer + i;
      EXPECT_TRUE(commit.Run([&](Connection& database) { return Insert(database, value); }).ok());
    }
  });
  const std::vector<int64_t> values = Values();
  ASSERT_EQ(values.size(), 50u * kWriters);
  std::vector<int64_t> next(kWriters);
  for (const int64_t value : values) EXPECT_EQ(value % 1000, next[value / 1000]++);
}

TEST_F(GroupCommitTest, OneThatThrowsFailsAlone) {
  GroupCommit commit(OpenTable());
  InThreads([&](int writer) {
    for (int i = 0; i < 50; ++i) {
      const int64_t value = 1000 * writer + i;
      const bool throws = (i + writer) % 10 == 0;
      const absl::Status status = commit.Run([&](Connection& database) -> absl::Status {
        absl::Status inserted = Insert(database, value);
        if (throws) throw std::bad_alloc();
        return inserted;
      });
      EXPECT_EQ(absl::IsResourceExhausted(status), throws) << status;
    }
  });
  EXPECT_EQ(Values().size(), 45u * kWriters);
}

// As SQLite does by itself when the disk is full: everything before goes too.
TEST_F(GroupCommitTest, OneThatTakesBackTheTransactionFailsAlone) {
  GroupCommit commit(OpenTable());
  std::atomic<int> failed = 0;
  InThreads([&](int writer) {
    for (int i = 0; i < 50; ++i) {
      const int64_t value = 1000 * writer + i;
      const bool is_bad = (i + writer) % 10 == 0;
      const absl::Status status = commit.Run([&](Connection& database) -> absl::Status {
        if (absl::Status inserted = Insert(database, value); !inserted.ok()) return inserted;
        if (!is_bad) return absl::OkStatus();
        database.Execute("ROLLBACK").IgnoreError();
        return absl::ResourceExhaustedError("the disk is full");
      });
      EXPECT_EQ(status.ok(), !is_bad) << status;
      if (absl::IsResourceExhausted(status)) ++failed;
    }
  });
  EXPECT_EQ(failed, 5 * kWriters);
  EXPECT_EQ(Values().size(), 45u * kWriters);
}

// A deferred constraint is checked by COMMIT only, which fails for the whole group then.
TEST_F(GroupCommitTest, OneThatCannotBeCommittedFailsAlone) {
  std::unique_ptr<Connection> database = OpenTable();
  ASSERT_TRUE(database
                  ->Execute("PRAGMA foreign_keys = ON; CREATE TABLE u (a INTEGER REFERENCES t (a) "
                            "DEFERRABLE INITIALLY DEFERRED)")
                  .ok());
  GroupCommit commit(std::move(database));
  std::atomic<int> begun = 0;
  InThreads([&](int writer) {
    ++begun;
    const bool is_bad = writer == 3;
    const absl::Status status = commit.Run([&](Connection& connection) -> absl::Status {
      while (begun < kWriters) std::this_thread::yield();  // So that most share a transaction.
      if (!is_bad) return Insert(connection, writer);
      return connection.Execute("INSERT INTO u VALUES (77)");
    });
    EXPECT_EQ(status.ok(), !is_bad) << status;
  });
  EXPECT_EQ(Values().size(), kWriters - 1u);
}

// A deadlock with an administrator's statement, for one.
TEST_F(GroupCommitTest, TriesAgainWhatWasTakenBackForOthers) {
  GroupCommit commit(OpenTable());
  int runs = 0;
  const absl::Status status = commit.Run([&](Connection& database) {
    return ++runs < 3 ? absl::AbortedError("in the way") : Insert(database, 7);
  });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(runs, 3);
  EXPECT_EQ(commit.Run([](Connection&) { return absl::AbortedError("in the way"); }).code(),
            StatusCode::kUnavailable);
  EXPECT_EQ(Values(), std::vector<int64_t>{7});
}

}  // namespace
}  // namespace isthmus::storage
