// A map folder as the first release left it, opened by this one: the same answers.
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"
#include "tests/faults/harness/answers.h"
#include "tests/faults/harness/damage.h"
#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

using storage::SqliteConnection;

// Tables and columns of schema 1, with the same rows.
void CopyAsSchema1(const std::string& from, const std::string& to) {
  std::filesystem::create_directories(to);
  auto database = SqliteConnection::Open(to + "/isthmus.db");
  ASSERT_TRUE(database.ok()) << database.status();
  const std::vector<storage::Migration> first(storage::Migrations().begin(),
                                              storage::Migrations().begin() + 1);
  ASSERT_TRUE(storage::Migrate(**database, first).ok());
  ASSERT_TRUE((*database)->Execute(absl::StrCat("ATTACH '", from, "/isthmus.db' AS later")).ok());
  const std::pair<const char*, const char*> kTables[] = {
      {"sessions", "key, id, robot, sensor, T_base_sensor, state, created_ns, finished_ns"},
      {"trajectory", "session, sequence, stamp_ns, submap_index, T_odom_sensor"},
      {"submaps",
       "key, session, submap_index, T_odom_submap, first_sequence, last_sequence, "
       "first_stamp_ns, last_stamp_ns, keyframe_count, point_count, min_x, min_y, min_z, max_x, "
       "max_y, max_z"},
      {"submap_blobs", "submap, data"},
      {"revisions", "revision, stamp_ns, cause"},
      {"placements", "revision, session, component, reference, T_map_odom"}};
  for (const auto& [table, columns] : kTables) {
    const absl::Status copied = (*database)->Execute(absl::StrCat(
        "INSERT INTO ", table, " (", columns, ") SELECT ", columns, " FROM later.", table));
    ASSERT_TRUE(copied.ok()) << table << ": " << copied;
  }
}

TEST(UpgradeTest, AFolderOfTheFirstReleaseAnswersTheSame) {
  const TestSetup setup;
  const std::string folder = MakeDamageMaster(setup.get());
  ServerProcess now(setup.get().server, setup.Path("now"), 8, folder);
  ASSERT_TRUE(now.Start()) << now.Log();
  const Answers wanted = AskAll(now.address());
  ASSERT_EQ(now.Stop(), 0) << now.Log();
  ASSERT_EQ(wanted.sessions.size(), 2u);
  ASSERT_GT(wanted.submaps.size(), 8u);

  CopyAsSchema1(folder, setup.Path("first"));
  ServerProcess later(setup.get().server, setup.Path("later"), 8, setup.Path("first"));
  ASSERT_TRUE(later.Start()) << later.Log();
  EXPECT_EQ(Difference(wanted, AskAll(later.address())), "");
  EXPECT_EQ(later.Stop(), 0) << later.Log();
  ChildProcess check(setup.get().server, {"--check", setup.Path("first")}, setup.Path("check"));
  EXPECT_NE(check.ReadAll().find("\nsound\n"), std::string::npos);
  EXPECT_EQ(check.Wait(), 0);
}

}  // namespace
}  // namespace isthmus::faults
