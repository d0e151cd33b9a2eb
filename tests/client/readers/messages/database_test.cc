// ROS 2 bags in databases and folders, as recorders leave them.
#include <sqlite3.h>

#include <filesystem>

#include "client/readers/messages/db3/bag_metadata.h"
#include "tests/client/readers/messages/damage_helpers.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class BagDatabaseTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(testing::TempDir()) / "isthmus_bag_database" / info->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  std::string Copy(const std::string& name) {
    fs::copy(DataFile(name), root_ / name, fs::copy_options::recursive);
    return root_ / name;
  }
  std::vector<std::string> Files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(root_))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
  static std::string Load(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
  }
  static AllMessages Read(const std::string& path) {
    auto file = OpenMessageFile(path);
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() ? ReadMessages(*file) : AllMessages();
  }

  fs::path root_;
};

void Execute(sqlite3* database, const char* sql) {
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, &error), SQLITE_OK) << error;
}

TEST_F(BagDatabaseTest, ALogThatWasLeftBehindIsReadAndLeftAsItIs) {
  const std::string original = Copy("drive.db3");
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(original.c_str(), &database), SQLITE_OK);
  Execute(database, "PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0;");
  Execute(database,
          "INSERT INTO messages (topic_id, timestamp, data) "
          "SELECT topic_id, 42, data FROM messages WHERE id = 1");
  // The recorder is killed: nobody writes the log into the database.
  const std::string killed = root_ / "killed.db3";
  fs::copy(original, killed);
  fs::copy(original + "-wal", killed + "-wal");
  sqlite3_close(database);
  fs::remove(original);
  const std::vector<std::string> before = Files();
  const std::string bytes = Load(killed), log = Load(killed + "-wal");
  const AllMessages all = Read(killed);
  EXPECT_THAT(all.messages, SizeIs(21));
  EXPECT_THAT(all.messages.front(), HasSubstr(" 42 "));  // Its time of recording is the earliest.
  EXPECT_THAT(all.notes, IsEmpty());
  EXPECT_EQ(Files(), before);
  EXPECT_EQ(Load(killed), bytes);
  EXPECT_EQ(Load(killed + "-wal"), log);
  // Without it there is what was written before.
  fs::remove(killed + "-wal");
  EXPECT_THAT(Read(killed).messages, SizeIs(20));
  EXPECT_THAT(Files(), ElementsAre("killed.db3"));
}

TEST_F(BagDatabaseTest, BehindDamagedPagesItGoesOn) {
  const AllMessages whole = Read(DataFile("drive.db3"));
  const std::string path = Copy("drive.db3");
  const std::string bytes = Load(path);
  size_t most = 0;
  for (size_t page = 2; page * 1024 < bytes.size(); ++page) {
    std::string damaged = bytes;
    damaged.replace(page * 1024, 1024, std::string(1024, '\xA5'));
    std::ofstream(path, std::ios::binary) << damaged;
    auto file = OpenMessageFile(path);
    if (!file.ok()) continue;
    const AllMessages left = ReadMessages(*file);
    if (!left.errors.empty()) most = std::max(most, left.messages.size());
  }
  EXPECT_GE(most, whole.messages.size() / 2);
}

TEST_F(BagDatabaseTest, OtherDatabasesAreRefused) {
  const std::string path = root_ / "other.db3";
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  Execute(database, "CREATE TABLE topics(id INTEGER PRIMARY KEY)");
  sqlite3_close(database);
  const auto file = OpenMessageFile(path);
  EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << file.status();
  EXPECT_THAT(std::string(file.status().message()), HasSubstr("no ROS 2 bag"));
}

TEST_F(BagDatabaseTest, AFolderWithoutMetadataIsReadInOrder) {
  const std::string folder = Copy("split_bag");
  const AllMessages whole = Read(folder);
  EXPECT_THAT(whole.messages, SizeIs(20));
  fs::remove(fs::path(folder) / "metadata.yaml");
  fs::rename(fs::path(folder) / "split_0.db3", fs::path(folder) / "split_9.db3");
  fs::rename(fs::path(folder) / "split_1.db3", fs::path(folder) / "split_10.db3");
  const AllMessages listed = Read(folder);
  EXPECT_EQ(listed.messages, whole.messages);
  EXPECT_THAT(listed.notes, ElementsAre(HasSubstr("no metadata.yaml")));
  std::ofstream(fs::path(folder) / "split_9.db3") << "damaged";
  const AllMessages second = Read(folder);
  EXPECT_THAT(second.messages, SizeIs(11));
  EXPECT_THAT(second.notes, ElementsAre(HasSubstr("metadata"), HasSubstr("split_9.db3")));
}

TEST_F(BagDatabaseTest, AFolderOfMcapFilesIsABag) {
  fs::copy(DataFile("drive_zstd.mcap"), root_ / "part_0.mcap");
  fs::copy(DataFile("drive_lz4.mcap"), root_ / "part_1.mcap");
  auto file = OpenMessageFile(root_);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ((*file)->kind(), "ROS 2 bag (MCAP)");
  EXPECT_EQ((*file)->topics()[0].messages, 6u);
  EXPECT_THAT(ReadMessages(*file).messages, SizeIs(40));
}

TEST_F(BagDatabaseTest, FilesThatAreCompressedAsAWholeAreRefused) {
  std::ofstream(root_ / "part_0.db3.zstd") << "\x28\xB5\x2F\xFD";
  EXPECT_TRUE(IsMessageFile(root_));
  for (const fs::path& path : {root_, root_ / "part_0.db3.zstd"}) {
    const auto file = OpenMessageFile(path);
    EXPECT_TRUE(absl::IsInvalidArgument(file.status()));
    EXPECT_THAT(std::string(file.status().message()), HasSubstr("zstd -d"));
  }
}

TEST(BagMetadataTest, WhatIsNoneIsRefused) {
  EXPECT_FALSE(ParseBagMetadata("").ok());
  EXPECT_FALSE(ParseBagMetadata("[1, 2").ok());
  EXPECT_FALSE(ParseBagMetadata("a: b").ok());
  EXPECT_FALSE(ParseBagMetadata("rosbag2_bagfile_information: 3").ok());
  EXPECT_TRUE(ParseBagMetadata("rosbag2_bagfile_information: {version: 4}").ok());
}

}  // namespace
}  // namespace isthmus::readers
