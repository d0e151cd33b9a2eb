// Files of a map folder that somebody took away or cut off while nobody had it open.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/io/file_io.h"
#include "storage/sqlite/sqlite.h"
#include "storage/sqlite/sqlite_store.h"
#include "storage/upkeep/check_store.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

class LostFilesTest : public ::testing::Test {
 protected:
  void Open(const SqliteOptions& options = {}) {
    const auto store = OpenSqliteStore(folder_.path(), options);
    EXPECT_TRUE(store.ok()) << store.status();
  }

  TemporaryFolder folder_;
};

TEST_F(LostFilesTest, MissesTheLogOfAStoreThatDied) {
  std::vector<std::string> problems;
  const SqliteOptions options{.on_problem = [&](const auto& text) { problems.push_back(text); }};
  Open(options);
  Open(options);
  EXPECT_THAT(problems, ::testing::IsEmpty()) << "a map that was closed has no log";
  std::ofstream(folder_.path() + "/isthmus.open") << "died";
  EXPECT_EQ(CheckStore(folder_.path())->damaged_count, 1);
  Open(options);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], HasSubstr("missing"));
  EXPECT_EQ(CheckStore(folder_.path())->damaged_count, 0) << "said once";
}

// SQLite alone would begin a new database and throw the log away.
TEST_F(LostFilesTest, RefusesADatabaseThatWasCutOffAndKeepsItsLog) {
  Open();
  auto killed = SqliteConnection::Open(folder_.database());
  ASSERT_TRUE((*killed)->SetCheckpointOnClose(false).ok());
  ASSERT_TRUE((*killed)->Execute("PRAGMA user_version = 99").ok());
  killed->reset();
  std::filesystem::resize_file(folder_.database(), 0);
  const std::string log = *io::ReadFile(folder_.database() + "-wal");
  ASSERT_FALSE(log.empty());
  const absl::Status status = OpenSqliteStore(folder_.path()).status();
  EXPECT_EQ(status.code(), StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr("cut off"));
  EXPECT_EQ(std::filesystem::file_size(folder_.database()), 0u);
  EXPECT_EQ(*io::ReadFile(folder_.database() + "-wal"), log);
}

}  // namespace
}  // namespace isthmus::storage
