// A map goes from SQLite to PostgreSQL and back, and is the same.
#include "fleet/copy/copy_map.h"

#include <absl/strings/ascii.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "core/io/file_io.h"
#include "fleet/postgresql/migrations.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/site_writer.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite_store.h"
#include "storage/sqlite/tables.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

std::set<std::string> TextsOf(Connection& database, const std::string& sql) {
  auto texts = database.Prepare(sql).ReadAll(
      [](const Statement& row) { return absl::AsciiStrToLower(row.Text(0)); });
  EXPECT_TRUE(texts.ok()) << texts.status();
  if (!texts.ok()) return {};
  return std::set<std::string>(texts->begin(), texts->end());
}

class CopyMapTest : public ::testing::Test {
 protected:
  // A map with something in most tables, in `folder`.
  void Fill(const std::string& folder) {
    auto store = OpenSqliteStore(folder, {.sync_every_commit = false});
    ASSERT_TRUE(store.ok()) << store.status();
    WriteBatch batch = {.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
                        .checkpoints = {{SessionId("bob-1"), 3, 3, std::string(70'000, 'c')}}};
    for (uint32_t index = 0; index < 40; ++index) {
      batch.submaps.push_back(MakeSubmap("alice-1", index));
    }
    for (uint64_t sequence = 1; sequence <= 5000; ++sequence) {
      batch.trajectory.emplace_back(SessionId("bob-1"), MakeEntry(sequence));
    }
    batch.matches = {MakeMatch("alice-1", "bob-1")};
    batch.matching_progress = {{SessionId("alice-1"), 40}};
    batch.events = {MakeEvent(EventKind::kServerStarted, 5)};
    const absl::Status status = (*store)->Write(batch);
    ASSERT_TRUE(status.ok()) << status;
    ASSERT_TRUE((*store)->PutFeatures({{SessionId("alice-1"), 3}, "prepared-v1", "abc"}).ok());
  }

  PostgresServer& server_ = PostgresServer::Shared();
  const std::string site_ = server_.NewSite();
  const MapPlace database_{server_.url(), site_};
  TemporaryFolder folder_, second_;
};

TEST_F(CopyMapTest, ThereAndBack) {
  Fill(folder_.path());
  const auto there = CopyMap({folder_.path()}, database_);
  ASSERT_TRUE(there.ok()) << there.status();
  EXPECT_EQ(there->sessions, 2);
  EXPECT_EQ(there->submaps, 40);
  EXPECT_EQ(there->scans, 5000);
  const auto back = CopyMap(database_, {second_.path()});
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->records, there->records);
  const auto store = OpenSqliteStore(second_.path());
  ASSERT_TRUE(store.ok()) << store.status();
  const auto first = OpenSqliteStore(folder_.path());
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ((*store)->GetTrajectory(SessionId("bob-1"))->size(), 5000u);
  EXPECT_EQ((*store)->ListMatches()->size(), 1u);
  EXPECT_EQ(*(*store)->GetFeatures({SessionId("alice-1"), 3}, "prepared-v1"), "abc");
  EXPECT_EQ(*(*store)->GetCheckpoint(SessionId("bob-1"))->data, std::string(70'000, 'c'));
  const auto a = (*store)->GetSubmap({SessionId("alice-1"), 39});
  const auto b = (*first)->GetSubmap({SessionId("alice-1"), 39});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ((*a)->points.size(), (*b)->points.size());
}

// The copy counts keys on behind those that came.
TEST_F(CopyMapTest, TheCopyGoesOn) {
  Fill(folder_.path());
  ASSERT_TRUE(CopyMap({folder_.path()}, database_).ok());
  const auto copy = OpenPostgresStore(server_.url(), site_);
  ASSERT_TRUE(copy.ok()) << copy.status();
  const absl::Status status =
      (*copy)->Write({.sessions = {MakeSession("carol-1")}, .submaps = {MakeSubmap("carol-1", 0)}});
  EXPECT_TRUE(status.ok()) << status;
}

TEST_F(CopyMapTest, RefusesSitesThatNoServerServes) {
  Fill(folder_.path());
  for (const std::string site : {"a b", ".hidden", "a/b", "n\303\244he"}) {
    const absl::Status status = CopyMap({folder_.path()}, {server_.url(), site}).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << site;
    EXPECT_EQ(CopyMap({server_.url(), site}, {second_.path()}).status().code(),
              StatusCode::kInvalidArgument);
  }
}

TEST_F(CopyMapTest, RefusesWhatIsInUseOrThereAlready) {
  EXPECT_EQ(CopyMap({folder_.path()}, database_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(CopyMap(database_, {folder_.path()}).status().code(), StatusCode::kNotFound);
  Fill(folder_.path());
  {
    const auto server = OpenPostgresStore(server_.url(), site_);
    ASSERT_TRUE(server.ok()) << server.status();
    EXPECT_EQ(CopyMap({folder_.path()}, database_).status().code(),
              StatusCode::kFailedPrecondition);
  }
  ASSERT_TRUE(CopyMap({folder_.path()}, database_).ok());
  EXPECT_EQ(CopyMap({folder_.path()}, database_).status().code(), StatusCode::kAlreadyExists);
}

// A value that PostgreSQL refuses stands in the last table: nothing of the others is kept.
TEST_F(CopyMapTest, IsAllOrNothing) {
  Fill(folder_.path());
  {
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(
        (*database)->Prepare("UPDATE events SET text = ?").Bind(std::string(1, '\0')).Run().ok());
  }
  const auto failed = CopyMap({folder_.path()}, database_);
  EXPECT_EQ(failed.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(failed.status().message()), HasSubstr("table events"));
  const auto store = OpenPostgresStore(server_.url(), site_);
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_TRUE((*store)->ListSessions()->empty());
}

// Each is copied as it is, for --check to name: nothing of the damage ends the copy.
TEST_F(CopyMapTest, NumbersAndPosesThatNoSubmapHasAreCopied) {
  Fill(folder_.path());
  {
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok());
    for (const std::string change : {"submap_index = -1 WHERE submap_index = 7",
                                     "submap_index = 4294967296 WHERE "
                                     "submap_index = 8",
                                     "T_odom_submap = x'00' WHERE submap_index = 9",
                                     "min_x = 9e999 WHERE submap_index = 10"}) {
      const absl::Status status = (*database)->Execute("UPDATE submaps SET " + change);
      ASSERT_TRUE(status.ok()) << status;
    }
  }
  const auto copied = CopyMap({folder_.path()}, {second_.path()});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_EQ(copied->submaps, 40);
  EXPECT_FALSE(std::filesystem::exists(second_.database() + ".partial"));
}

TEST_F(CopyMapTest, WhatACopyLeftThatWasKilledIsReplaced) {
  Fill(folder_.path());
  std::filesystem::create_directories(second_.path());
  ASSERT_TRUE(io::WriteFile(second_.database() + ".partial", "half a database").ok());
  EXPECT_FALSE(OpenSqliteStore(second_.path()).ok());
  const auto copied = CopyMap({folder_.path()}, {second_.path()});
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_TRUE(OpenSqliteStore(second_.path()).ok());
}

// Tables without a map would be served as one.
TEST_F(CopyMapTest, LeavesNoDatabaseInAFolderWhereItFailed) {
  Fill(folder_.path());
  {
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok());
    const absl::Status status =
        (*database)->Execute("PRAGMA ignore_check_constraints = ON; UPDATE sessions SET state = 7");
    ASSERT_TRUE(status.ok()) << status;
  }
  EXPECT_FALSE(CopyMap({folder_.path()}, {second_.path()}).ok());
  EXPECT_FALSE(std::filesystem::exists(second_.database()));
  EXPECT_FALSE(std::filesystem::exists(second_.database() + ".partial"));
}

// A migration that PostgreSQL has for itself makes the tables and columns of the other.
TEST_F(CopyMapTest, BothDatabasesHaveTheSameTables) {
  ASSERT_TRUE(OpenSqliteStore(folder_.path()).ok());
  ASSERT_TRUE(OpenPostgresStore(server_.url(), site_).ok());
  const auto sqlite = SqliteConnection::Open(folder_.database());
  const std::string schema = SchemaOfSite(site_);
  const auto postgres = PostgresConnection::Open({server_.url(), schema, "test", true});
  ASSERT_TRUE(sqlite.ok() && postgres.ok());
  std::set<std::string> names;
  const auto tables = MapTables();
  ASSERT_TRUE(tables.ok()) << tables.status();
  for (const Table& table : *tables) {
    names.insert(table.name);
    std::set<std::string> columns;
    for (const TableColumn& column : table.columns)
      columns.insert(absl::AsciiStrToLower(column.name));
    EXPECT_EQ(TextsOf(**sqlite, "SELECT name FROM pragma_table_info('" + table.name + "')"),
              columns);
    EXPECT_EQ(TextsOf(**postgres,
                      "SELECT column_name::text FROM information_schema.columns WHERE "
                      "table_schema = '" +
                          schema + "' AND table_name = '" + table.name + "'"),
              columns);
  }
  EXPECT_EQ(TextsOf(**sqlite,
                    "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE "
                    "'sqlite_%'"),
            names);
  names.insert({"about", "jobs", "lease", "owners", "workers"});
  EXPECT_EQ(TextsOf(**postgres,
                    "SELECT table_name::text FROM information_schema.tables WHERE "
                    "table_schema = '" +
                        schema + "'"),
            names);
  EXPECT_EQ(PostgresMigrations().back().version, Migrations().back().version);
}

}  // namespace
}  // namespace isthmus::storage
