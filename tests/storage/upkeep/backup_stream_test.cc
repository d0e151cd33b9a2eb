#include "storage/upkeep/backup_stream.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/io/file_io.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

class BackupStreamTest : public testing::Test {
 protected:
  BackupStreamTest() {
    auto store = OpenSqliteStore(folder_.path(), {.sync_every_commit = false});
    EXPECT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
    EXPECT_TRUE(store_->Write({.sessions = {MakeSession("alice-1")}}).ok());
    for (uint32_t i = 0; i < 30; ++i) {
      EXPECT_TRUE(store_->Write({.submaps = {MakeSubmap("alice-1", i, 2000)}}).ok());
    }
  }

  size_t Entries() const {
    const std::filesystem::directory_iterator all(folder_.path());
    return static_cast<size_t>(std::distance(begin(all), end(all)));
  }

  TemporaryFolder folder_;
  std::unique_ptr<MapStore> store_;
};

TEST_F(BackupStreamTest, TheBytesAreAMapFolderAndNothingIsLeft) {
  const size_t before = Entries();
  std::string bytes;
  uint64_t announced = 0;
  BackupReader reader;
  reader.begin = [&](uint64_t size) { announced = size; };
  reader.piece = [&](const std::string& piece) {
    bytes += piece;
    return true;
  };
  const auto report = StreamBackup(folder_.path(), reader);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->submaps, 30);
  EXPECT_EQ(report->damaged_count, 0);
  EXPECT_EQ(bytes.size(), announced);
  EXPECT_EQ(Entries(), before);

  const TemporaryFolder copy;
  std::filesystem::create_directories(copy.path());
  std::ofstream(copy.database(), std::ios::binary) << bytes;
  const auto opened = OpenSqliteStore(copy.path());
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ((*opened)->ListSubmaps(std::nullopt)->size(), 30u);
}

TEST_F(BackupStreamTest, AReaderThatGivesUpLeavesNothing) {
  const size_t before = Entries();
  BackupReader reader;
  reader.piece = [](const std::string&) { return false; };
  EXPECT_TRUE(absl::IsCancelled(StreamBackup(folder_.path(), reader).status()));
  reader.progress = [](double) { return false; };
  EXPECT_TRUE(absl::IsCancelled(StreamBackup(folder_.path(), reader).status()));
  EXPECT_EQ(Entries(), before);
}

TEST_F(BackupStreamTest, WhatADeadProcessLeftIsRemovedAndNothingElse) {
  const size_t before = Entries();
  std::filesystem::create_directories(folder_.path() + "/backup-7-1.partial-abc");
  std::ofstream(folder_.path() + "/backup-7-1.partial-abc/isthmus.db") << "half";
  RemoveAbandonedBackups(folder_.path());
  EXPECT_EQ(Entries(), before);
  EXPECT_TRUE(std::filesystem::exists(folder_.database()));
}

}  // namespace
}  // namespace isthmus::storage
