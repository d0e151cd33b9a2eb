#include "storage/sqlite/migrations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class MigrationsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_.path());
    auto database = SqliteConnection::Open(folder_.database());
    ASSERT_TRUE(database.ok()) << database.status();
    database_ = *std::move(database);
  }

  int64_t Number(const std::string& sql) {
    Statement statement = database_->Prepare(sql);
    const auto row = statement.Step();
    return row.ok() && *row ? statement.Int(0) : -1;
  }

  const Migration one_{1, "0001_one.sql", "CREATE TABLE t (a INTEGER); INSERT INTO t VALUES (7);"};
  const Migration two_{2, "0002_two.sql", "ALTER TABLE t ADD COLUMN b INTEGER DEFAULT 8"};
  TemporaryFolder folder_;
  std::unique_ptr<SqliteConnection> database_;
};

TEST_F(MigrationsTest, OfTheProgramCountWithoutGaps) {
  int64_t expected = 1;
  for (const Migration& migration : Migrations()) {
    EXPECT_EQ(migration.version, expected);
    char number[8];
    std::snprintf(number, sizeof(number), "%04d_", static_cast<int>(expected++));
    EXPECT_THAT(std::string(migration.file), StartsWith(number));
  }
  EXPECT_GT(expected, 1);
}

TEST_F(MigrationsTest, RunEachOnce) {
  ASSERT_TRUE(Migrate(*database_, {one_}).ok());
  ASSERT_TRUE(Migrate(*database_, {one_, two_}).ok());
  ASSERT_TRUE(Migrate(*database_, {one_, two_}).ok());
  EXPECT_EQ(Number("PRAGMA user_version"), 2);
  EXPECT_EQ(Number("SELECT count(*) FROM t WHERE a = 7 AND b = 8"), 1);
}

TEST_F(MigrationsTest, AreTakenBackWhenTheyFail) {
  const Migration bad{2, "0002_bad.sql", "INSERT INTO t VALUES (9); SELECT no_such_column FROM t"};
  const absl::Status status = Migrate(*database_, {one_, bad});
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), HasSubstr("0002_bad.sql"));
  EXPECT_EQ(Number("PRAGMA user_version"), 1);
  EXPECT_EQ(Number("SELECT count(*) FROM t"), 1);
  EXPECT_TRUE(Migrate(*database_, {one_, two_}).ok());
}

TEST_F(MigrationsTest, KeepTheSessionsOfTheFirstSchema) {
  ASSERT_TRUE(Migrate(*database_, {Migrations().front()}).ok());
  ASSERT_TRUE(database_
                  ->Execute("INSERT INTO sessions (id, robot, sensor, T_base_sensor, state, "
                            "created_ns, finished_ns) VALUES ('a-1', 'a', 'vlp16', x'00', 1, 5, 6)")
                  .ok());
  ASSERT_TRUE(Migrate(*database_).ok());
  EXPECT_EQ(Number("SELECT count(*) FROM sessions WHERE id = 'a-1' AND odometry = ''"), 1);
}

TEST_F(MigrationsTest, RefuseWhatIsNewer) {
  ASSERT_TRUE(Migrate(*database_, {one_, two_}).ok());
  EXPECT_EQ(CheckSchema(*database_, {one_}).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(CheckSchema(*database_, {one_, two_}).ok());
}

}  // namespace
}  // namespace isthmus::storage
