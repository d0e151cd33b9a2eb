// Promises of the store in PostgreSQL alone: one owner, truth about commits, and going on.
#include "fleet/postgresql/postgres_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "fleet/postgresql/migrations.h"
#include "fleet/postgresql/postgresql.h"
#include "storage/sqlite/sqlite.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/records.h"
#include "tests/storage/schema13.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> SessionsIn(const MapStore& store) {
  const auto sessions = store.ListSessions();
  EXPECT_TRUE(sessions.ok()) << sessions.status();
  std::vector<std::string> ids;
  if (!sessions.ok()) return ids;
  for (const SessionRecord& record : *sessions) ids.push_back(record.id.value());
  return ids;
}

class PostgresStoreTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<MapStore>> Open(const PostgresOptions& options = {}) {
    return OpenPostgresStore(server_.url(), site_, options);
  }
  std::string schema() const { return SchemaOfSite(site_); }

  PostgresServer& server_ = PostgresServer::Shared();
  const std::string site_ = server_.NewSite();
};

TEST_F(PostgresStoreTest, IsThereAfterItWasClosed) {
  {
    const auto store = Open();
    ASSERT_TRUE(store.ok()) << store.status();
    ASSERT_TRUE(
        (*store)
            ->Write({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}})
            .ok());
    EXPECT_GT((*store)->SizeOnDisk().database, 0u);
  }
  const auto store = Open();
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_EQ((*store)->ListSubmaps(std::nullopt)->size(), 1u);
}

TEST_F(PostgresStoreTest, SitesShareADatabaseAndNothingElse) {
  const auto store = Open();
  const auto other = OpenPostgresStore(server_.url(), server_.NewSite());
  ASSERT_TRUE(store.ok() && other.ok());
  ASSERT_TRUE((*store)->Write({.sessions = {MakeSession("alice-1")}}).ok());
  EXPECT_TRUE(SessionsIn(**other).empty());
}

TEST_F(PostgresStoreTest, ASecondServerIsToldWhoHasTheSite) {
  const auto store = Open();
  ASSERT_TRUE(store.ok());
  const auto second = Open();
  EXPECT_EQ(second.status().code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("process " + std::to_string(getpid())));
  EXPECT_TRUE((*store)->Write({.sessions = {MakeSession("alice-1")}}).ok());
}

TEST_F(PostgresStoreTest, WhoWasTakenForDeadDoesNotWriteAnyMore) {
  const auto paused = Open();
  ASSERT_TRUE(paused.ok());
  ASSERT_TRUE((*paused)->Write({.sessions = {MakeSession("alice-1")}}).ok());
  {
    absl::StatusOr<std::unique_ptr<MapStore>> next = absl::UnknownError("not opened");
    while (!next.ok()) {  // It may be back before another one has come.
      ASSERT_TRUE(
          server_.Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                          "application_name LIKE '" +
                          schema() + " %'"));
      next = Open();
    }
    const absl::Status late = (*paused)->Write({.sessions = {MakeSession("bob-1")}});
    EXPECT_EQ(late.code(), StatusCode::kUnavailable);
    EXPECT_THAT(std::string(late.message()), HasSubstr("one server at a time"));
    ASSERT_TRUE((*next)->Write({.sessions = {MakeSession("carol-1")}}).ok());
  }
  // Neither once the other one is gone: its writes are unknown here.
  EXPECT_EQ((*paused)->Write({.sessions = {MakeSession("bob-1")}}).code(),
            StatusCode::kUnavailable);
  const auto now = Open();
  ASSERT_TRUE(now.ok()) << now.status();
  EXPECT_EQ(SessionsIn(**now), (std::vector<std::string>{"alice-1", "carol-1"}));
}

TEST_F(PostgresStoreTest, GoesOnWhereConnectionsWereCut) {
  const auto store = Open();
  ASSERT_TRUE(store.ok());
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(
        server_.Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                        "application_name LIKE '" +
                        schema() + " %'"));
    EXPECT_TRUE((*store)->Write({.sessions = {MakeSession("s-" + std::to_string(i))}}).ok());
    EXPECT_EQ(SessionsIn(**store).size(), static_cast<size_t>(i + 1));
  }
}

// Every commit is made to take a while, in which its connection is cut: by a trigger that runs at
// the very end of the transaction.
TEST_F(PostgresStoreTest, TellsTheTruthAboutACommitThatWasCut) {
  const auto store = Open();
  ASSERT_TRUE(store.ok());
  ASSERT_TRUE(server_.Execute(
      "CREATE FUNCTION " + schema() +
      ".dawdle() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN "
      "PERFORM pg_sleep(0.02); RETURN NULL; END $$; CREATE CONSTRAINT TRIGGER dawdle AFTER INSERT "
      "ON " +
      schema() + ".sessions DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION " +
      schema() + ".dawdle()"));
  std::atomic<bool> is_done = false;
  std::thread cutter([&] {
    while (!is_done) {
      server_.Execute(
          "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
          "application_name = '" +
          schema() +
          " writer' AND query = 'COMMIT' AND "
          "state = 'active' AND random() < 0.5");
    }
  });
  std::vector<std::string> stored;
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string id = "s-" + std::to_string(1000 + i);
    const absl::Status status = (*store)->Write({.sessions = {MakeSession(id)}});
    if (status.ok()) {
      stored.push_back(id);
    } else {
      EXPECT_EQ(status.code(), StatusCode::kUnavailable) << status;
      ++refused;
    }
  }
  is_done = true;
  cutter.join();
  EXPECT_EQ(SessionsIn(**store), stored);
  EXPECT_GT(refused, 0);
  EXPECT_GT(stored.size(), 0u);
}

// Threads write while the server is killed and comes back. A batch is there as a whole if it was
// OK, and not at all else.
TEST_F(PostgresStoreTest, LosesNothingWhenTheServerIsKilled) {
  const auto server = PostgresServer::Start();
  ASSERT_NE(server, nullptr);
  auto store = OpenPostgresStore(server->url(), "");
  ASSERT_TRUE(store.ok()) << store.status();
  constexpr int kWriters = 4;
  std::atomic<bool> is_done = false;
  std::atomic<int> count = 0;
  std::array<std::vector<std::string>, kWriters> stored;
  std::vector<std::thread> writers;
  writers.reserve(kWriters);
  for (int writer = 0; writer < kWriters; ++writer) {
    writers.emplace_back([&, writer] {
      for (int i = 0; !is_done; ++i) {
        const std::string id = "w" + std::to_string(writer) + "-" + std::to_string(i);
        const absl::Status status = (*store)->Write(
            {.sessions = {MakeSession(id)}, .submaps = {MakeSubmap(id, 0), MakeSubmap(id, 1)}});
        if (status.ok()) stored[static_cast<size_t>(writer)].push_back(id);
        if (status.ok()) ++count;
      }
    });
  }
  for (int kill = 1; kill <= 3; ++kill) {
    while (count < 50 * kill) std::this_thread::yield();
    server->Kill();
    ASSERT_TRUE(server->StartAgain());
  }
  while (count < 200) std::this_thread::yield();
  is_done = true;
  for (std::thread& writer : writers) writer.join();
  store->reset();
  store = OpenPostgresStore(server->url(), "");
  ASSERT_TRUE(store.ok()) << store.status();
  size_t sessions = 0;
  for (const auto& ids : stored) {
    sessions += ids.size();
    for (const std::string& id : ids) {
      const auto submaps = (*store)->ListSubmaps(SessionId(id));
      ASSERT_TRUE(submaps.ok()) << submaps.status();
      EXPECT_EQ(submaps->size(), 2u);
    }
  }
  EXPECT_EQ(SessionsIn(**store).size(), sessions);
}

TEST_F(PostgresStoreTest, IsUnavailableWhileTheServerIsAway) {
  const auto server = PostgresServer::Start();
  ASSERT_NE(server, nullptr);
  const auto store = OpenPostgresStore(server->url(), "");
  ASSERT_TRUE(store.ok()) << store.status();
  server->Kill();
  // Its processes answer until they notice.
  absl::Status written, read;
  while (written.ok()) written = (*store)->Write({.sessions = {MakeSession("alice-1")}});
  while (read.ok()) read = (*store)->ListSessions().status();
  EXPECT_EQ(written.code(), StatusCode::kUnavailable);
  EXPECT_EQ(read.code(), StatusCode::kUnavailable);
  // A line of a log.
  EXPECT_EQ(read.message().find_first_of("\n\t"), std::string_view::npos) << read.message();
  ASSERT_TRUE(server->StartAgain());
  while (!(*store)->Write({.sessions = {MakeSession("alice-1")}}).ok()) std::this_thread::yield();
  while (!(*store)->ListSessions().ok()) std::this_thread::yield();
  EXPECT_EQ(SessionsIn(**store).size(), 1u);
}

TEST_F(PostgresStoreTest, NoticesAnOlderState) {
  const auto store = Open();
  ASSERT_TRUE((*store)->Write({.sessions = {MakeSession("alice-1")}}).ok());
  // As a replica that lacks the last commit.
  ASSERT_TRUE(server_.Execute("UPDATE " + schema() +
                              ".owners SET last_commit = 0; SELECT "
                              "pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                              "application_name LIKE '" +
                              schema() + " %'"));
  const absl::Status status = (*store)->Write({.sessions = {MakeSession("bob-1")}});
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("restart this server"));
}

TEST_F(PostgresStoreTest, RefusesWhatItCannotServe) {
  ASSERT_TRUE(Open().ok());
  ASSERT_TRUE(server_.Execute("UPDATE " + schema() + ".about SET version = 9999"));
  const auto newer = Open();
  EXPECT_EQ(newer.status().code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(newer.status().message()), HasSubstr("newer Isthmus"));
  const std::string foreign = server_.NewSite();
  ASSERT_TRUE(server_.Execute("CREATE SCHEMA " + SchemaOfSite(foreign) + "; CREATE TABLE " +
                              SchemaOfSite(foreign) + ".sessions (a INT)"));
  EXPECT_EQ(OpenPostgresStore(server_.url(), foreign).status().code(),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(OpenPostgresStore("postgresql:///x?host=/nowhere", "").status().code(),
            StatusCode::kUnavailable);
  EXPECT_EQ(OpenPostgresStore("postgresql://me:secret@host/db", "").status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(OpenPostgresStore("nonsense", "").status().code(), StatusCode::kInvalidArgument);
}

TEST_F(PostgresStoreTest, MatchingGoesOnWhereItWasInSchema13) {
  const auto database = PostgresConnection::Open({server_.url(), schema(), "test", true});
  ASSERT_TRUE(database.ok()) << database.status();
  std::vector<Migration> thirteen = PostgresMigrations();
  std::erase_if(thirteen, [](const Migration& migration) { return migration.version > 13; });
  ASSERT_TRUE(MigratePostgres(**database, schema(), thirteen).ok());
  FillSchema13(**database);
  const auto store = Open();
  ASSERT_TRUE(store.ok()) << store.status();
  ExpectProgressOfSchema13(**store, **database);
}

TEST_F(PostgresStoreTest, TakesMigrationsThatAreWrittenForSqlite) {
  const std::string sql =
      "CREATE TABLE things (\n  key INTEGER PRIMARY KEY,\n  name TEXT NOT NULL UNIQUE,\n"
      "  size REAL,\n  data BLOB\n) STRICT;\n"
      "CREATE TABLE pairs (a INTEGER NOT NULL, b INTEGER, PRIMARY KEY (a)) STRICT, WITHOUT ROWID;\n"
      "INSERT INTO things (name, size) VALUES ('one', 1.5);\n"
      "ALTER TABLE things ADD COLUMN note TEXT NOT NULL DEFAULT '';\n"
      "UPDATE things SET note = CAST(key AS TEXT)";
  const auto sqlite = SqliteConnection::Open(":memory:");
  ASSERT_TRUE(sqlite.ok() && (*sqlite)->Execute(sql).ok());
  const std::string schema = SchemaOfSite(server_.NewSite());
  const auto database = PostgresConnection::Open({server_.url(), schema, "test", true});
  ASSERT_TRUE(database.ok()) << database.status();
  const absl::Status status =
      MigratePostgres(**database, schema, {{12, "0012_both.sql", InPostgres(sql)}});
  ASSERT_TRUE(status.ok()) << status;
  const auto columns =
      (*database)
          ->Prepare(
              "SELECT column_name || ' ' || data_type || ' ' || coalesce(collation_name, '') FROM "
              "information_schema.columns WHERE table_schema = ? AND table_name <> 'about' "
              "ORDER BY table_name DESC, ordinal_position")
          .Bind(schema)
          .ReadAll([](const Statement& row) { return row.Text(0); });
  ASSERT_TRUE(columns.ok()) << columns.status();
  EXPECT_THAT(*columns, ElementsAre("key bigint ", "name text C", "size double precision ",
                                    "data bytea ", "note text C", "a bigint ", "b bigint "));
  EXPECT_EQ(*(*database)->ReadNumber("SELECT count(*) FROM things WHERE note = '1'"), 1);
}

TEST_F(PostgresStoreTest, MigratesEachStepOnce) {
  const std::string schema = SchemaOfSite(server_.NewSite());
  const auto database = PostgresConnection::Open({server_.url(), schema, "test", true});
  ASSERT_TRUE(database.ok()) << database.status();
  const Migration one{12, "0012_one.sql", "CREATE TABLE t (a BIGINT); INSERT INTO t VALUES (7)"};
  const Migration two{13, "0013_two.sql", "ALTER TABLE t ADD COLUMN b BIGINT DEFAULT 8"};
  const Migration bad{14, "0014_bad.sql", "INSERT INTO t VALUES (9); SELECT no_such FROM t"};
  ASSERT_TRUE(MigratePostgres(**database, schema, {one}).ok());
  ASSERT_TRUE(MigratePostgres(**database, schema, {one, two}).ok());
  const absl::Status failed = MigratePostgres(**database, schema, {one, two, bad});
  EXPECT_THAT(std::string(failed.message()), HasSubstr("0014_bad.sql"));
  ASSERT_TRUE(MigratePostgres(**database, schema, {one, two}).ok());
  EXPECT_EQ(*(*database)->ReadNumber("SELECT count(*) FROM t WHERE a = 7 AND b = 8"), 1);
  EXPECT_EQ(*(*database)->ReadNumber("SELECT version FROM about"), 13);
}

}  // namespace
}  // namespace isthmus::storage
