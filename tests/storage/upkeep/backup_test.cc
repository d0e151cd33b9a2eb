#include "storage/upkeep/backup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <thread>

#include "core/io/file_io.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class BackupTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_.path());
    store_ = Open(map_);
    ASSERT_TRUE(store_
                    ->Write({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
                             .matches = {MakeMatch("alice-1", "bob-1")},
                             .revision = MakeRevision(1)})
                    .ok());
    for (uint32_t i = 0; i < 40; ++i) ASSERT_TRUE(Append(i).ok());
  }

  static std::unique_ptr<MapStore> Open(const std::string& path) {
    auto store = OpenSqliteStore(path, {.sync_every_commit = false});
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }
  absl::Status Append(uint32_t i) {
    return store_->Write(
        {.trajectory = {{alice_, MakeEntry(i)}}, .submaps = {MakeSubmap("alice-1", i, 2000)}});
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename());
    }
    return names;
  }
  void ExpectNoTrace() const { EXPECT_THAT(Names(), ElementsAre("map")); }

  TemporaryFolder folder_;
  const SessionId alice_{"alice-1"};
  const std::string map_ = folder_.path() + "/map";
  const std::string target_ = folder_.path() + "/copy";
  std::unique_ptr<MapStore> store_;
};

TEST_F(BackupTest, IsTheMapWhenOpened) {
  const auto report = BackUp(map_, target_);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->damaged_count, 0) << ToString(*report);
  EXPECT_EQ(report->submaps, 40);
  // One file, which can be sent anywhere.
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(target_)) {
    names.push_back(entry.path().filename());
  }
  EXPECT_THAT(names, ElementsAre("isthmus.db"));
  store_ = nullptr;
  std::filesystem::remove_all(map_);
  store_ = Open(target_);
  EXPECT_EQ(store_->ListSessions()->size(), 2u);
  EXPECT_EQ(store_->GetTrajectory(alice_)->size(), 40u);
  EXPECT_EQ((*store_->GetSubmap({alice_, 39}))->points.size(), 2000u);
  EXPECT_EQ(store_->ListMatches()->size(), 1u);
  EXPECT_EQ(store_->LatestRevision()->revision, 1);
  EXPECT_TRUE(Append(40).ok());
}

// Submaps and scans are written together: as many of the ones as of the others, whenever it is.
TEST_F(BackupTest, IsOfOneMomentWhileWritesGoOn) {
  std::atomic<bool> is_done = false;
  std::atomic<uint32_t> next = 40;
  std::thread writer([&] {
    while (!is_done) {
      EXPECT_TRUE(Append(next).ok());
      ++next;
    }
  });
  uint32_t last = 0;
  int pauses = 0;
  for (int i = 0; i < 5; ++i) {
    const std::string target = target_ + std::to_string(i);
    const uint32_t before = next;
    // Some are written in the middle of it.
    const auto report = BackUp(map_, target, [&](double) {
      ++pauses;
      const uint32_t now = next;
      while (next == now) std::this_thread::yield();
      return true;
    });
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_EQ(report->damaged_count, 0) << ToString(*report);
    EXPECT_EQ(report->scans, report->submaps);
    EXPECT_GE(report->submaps, before);
    EXPECT_LT(report->submaps, next);
    last = static_cast<uint32_t>(report->submaps);
  }
  is_done = true;
  writer.join();
  EXPECT_GE(pauses, 5);
  const auto copy = Open(target_ + "4");
  EXPECT_EQ(copy->ListSubmaps(alice_)->size(), last);
  EXPECT_TRUE(copy->GetSubmap({alice_, last - 1}).ok());
  EXPECT_EQ(store_->ListSubmaps(alice_)->size(), next);
}

TEST_F(BackupTest, LeavesNoTraceWhenItFails) {
  int calls = 0;
  const auto give_up = [&](double share) {
    EXPECT_GE(share, 0);
    EXPECT_LE(share, 1);
    return ++calls < 2;
  };
  EXPECT_EQ(BackUp(map_, target_, give_up).status().code(), StatusCode::kCancelled);
  ExpectNoTrace();
  EXPECT_EQ(BackUp(folder_.path() + "/none", target_).status().code(), StatusCode::kNotFound);
  EXPECT_FALSE(BackUp(map_, folder_.path() + "/none/copy").ok());
  const absl::Status exists = BackUp(map_, map_).status();
  EXPECT_EQ(exists.code(), StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(exists.message()), HasSubstr("makes its own folder"));
  ExpectNoTrace();
  EXPECT_TRUE(Append(40).ok());
  EXPECT_TRUE(BackUp(map_, target_).ok());
}

TEST_F(BackupTest, SaysWhenItsDiskIsFull) {
  signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit limit{100'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
  const absl::Status status = BackUp(map_, target_).status();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted) << status;
  ExpectNoTrace();
}

TEST_F(BackupTest, KeepsAndReportsWhatIsDamaged) {
  store_ = nullptr;
  {
    auto database = SqliteConnection::Open(map_ + "/isthmus.db");
    ASSERT_TRUE((*database)->Execute("UPDATE submap_blobs SET data = x'00' WHERE submap = 3").ok());
  }
  const auto report = BackUp(map_, target_);
  ASSERT_TRUE(report.ok()) << report.status();
  ASSERT_EQ(report->damaged_count, 1) << ToString(*report);
  EXPECT_EQ(report->damaged[0].record, "submap alice-1/2");
  EXPECT_EQ(Open(target_)->ListSubmaps(alice_)->size(), 40u);
}

TEST_F(BackupTest, RefusesANewerMap) {
  store_ = nullptr;
  {
    auto database = SqliteConnection::Open(map_ + "/isthmus.db");
    ASSERT_TRUE((*database)->Execute("PRAGMA user_version = 99").ok());
  }
  EXPECT_EQ(BackUp(map_, target_).status().code(), StatusCode::kFailedPrecondition);
  ExpectNoTrace();
}

}  // namespace
}  // namespace isthmus::storage
