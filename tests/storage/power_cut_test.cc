// Acknowledged writes survive a power cut at any moment, and nothing is left half written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "storage/sqlite/sqlite_store.h"
#include "storage/upkeep/check_store.h"
#include "tests/storage/power_cut_disk.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

constexpr int kRobots = 4;
constexpr uint32_t kScans = 3;  // In a batch, whose number is its submap's.

SessionId RobotsSession(int writer) { return SessionId("robot-" + std::to_string(writer)); }

// One robot's view of the store.
struct Writer {
  uint32_t acknowledged = 0;  // Batches; their numbers are below.
  uint32_t next = 0;          // Up to here it tried.
};

WriteBatch BatchOf(int writer, uint32_t number) {
  const SessionId id = RobotsSession(writer);
  WriteBatch batch{.sessions = {MakeSession(id.value())},
                   .submaps = {MakeSubmap(id.value(), number, 400)},
                   .anchors = {MakeAnchor(id.value(), number)}};
  for (uint32_t i = 0; i < kScans; ++i) {
    batch.trajectory.push_back({id, MakeEntry(kScans * number + i)});
  }
  return batch;
}

class PowerCutTest : public ::testing::Test {
 protected:
  // Writes from all threads until the power fails; at the latest after `batches` of each, so that
  // it also fails while the store closes, which writes the log into the database.
  void WriteUntilTheCut(uint32_t batches, const SqliteOptions& options) {
    const auto store = OpenSqliteStore(folder_.path(), options);
    if (!store.ok()) {
      ASSERT_TRUE(disk_.is_off()) << store.status();
      return;
    }
    std::vector<std::thread> threads;
    for (int i = 0; i < kRobots; ++i) {
      threads.emplace_back([&, i] {
        Writer& writer = writers_[i];
        for (uint32_t n = 0; n < batches; ++n) {
          const bool is_acknowledged = (*store)->Write(BatchOf(i, writer.next)).ok();
          ++writer.next;
          if (!is_acknowledged) return;  // It may have got through or not.
          writer.acknowledged = writer.next;
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
  }

  // The number of acknowledged batches that are missing; everything else must be right.
  uint32_t Verify(const SqliteOptions& options) {
    const auto store = OpenSqliteStore(folder_.path(), options);
    EXPECT_TRUE(store.ok()) << store.status();
    if (!store.ok()) return 0;
    uint32_t missing = 0;
    size_t anchors = 0;
    for (int i = 0; i < kRobots; ++i) {
      uint32_t present = 0;
      const auto submaps = (*store)->ListSubmaps(RobotsSession(i));
      if (submaps.ok()) {
        present = static_cast<uint32_t>(submaps->size());
        // In order, none left out: none can be there without those before.
        for (uint32_t n = 0; n < present; ++n) EXPECT_EQ((*submaps)[n].id.index, n);
        if (present > 0) {
          EXPECT_TRUE((*store)->GetSubmap(submaps->back().id).ok());
        }
        EXPECT_EQ((*store)->GetTrajectory(RobotsSession(i))->size(), kScans * present);
      }
      anchors += present;
      EXPECT_LE(present, writers_[i].next);
      missing += writers_[i].acknowledged - std::min(present, writers_[i].acknowledged);
      // As a robot does: batches that were acknowledged or got through are not sent again.
      writers_[i] = {present, present};
    }
    EXPECT_EQ((*store)->ListAnchors()->size(), anchors);
    return missing;
  }

  // Cuts the power `cuts` times on one folder, within each `operations` or sooner.
  uint32_t CutManyTimes(int cuts, uint32_t operations, const SqliteOptions& options) {
    std::mt19937 random(11);
    uint32_t missing = 0;
    for (int cut = 0; cut < cuts && !HasFailure(); ++cut) {
      disk_.CutAfter(random() % operations);
      WriteUntilTheCut(random() % 20, options);
      disk_.Restore();
      missing += Verify(options);
      if (cut % 10 != 9) continue;
      const auto report = CheckStore(folder_.path());
      EXPECT_TRUE(report.ok()) << report.status();
      EXPECT_EQ(report->damaged_count, 0) << ToString(*report);
    }
    return missing;
  }

  TemporaryFolder folder_;
  PowerCutDisk disk_{5};
  Writer writers_[kRobots];
};

TEST_F(PowerCutTest, AcknowledgedBatchesSurviveWhole) {
  EXPECT_EQ(CutManyTimes(100, 600, {}), 0u);
  EXPECT_GT(disk_.lost_writes(), 300);
  EXPECT_GT(writers_[0].acknowledged, 100u);
}

// The test above can fail: without waiting for the disk, acknowledged batches do get lost, but not
// the file.
TEST_F(PowerCutTest, WithoutSyncTheLastOnesMayBeLost) {
  EXPECT_GT(CutManyTimes(40, 300, {.sync_every_commit = false}), 0u);
}

// Every single moment of making a map.
TEST_F(PowerCutTest, AMapThatWasBeingMadeIsMade) {
  bool was_cut = true;
  int64_t operations = 0;
  for (; was_cut && !HasFailure(); ++operations) {
    std::filesystem::remove_all(folder_.path());
    disk_.Forget();
    disk_.CutAfter(operations);
    (void)OpenSqliteStore(folder_.path());
    was_cut = disk_.is_off();
    disk_.Restore();
    const auto store = OpenSqliteStore(folder_.path());
    ASSERT_TRUE(store.ok()) << operations << ": " << store.status();
    EXPECT_TRUE((*store)->Write(BatchOf(0, 0)).ok());
  }
  EXPECT_GT(operations, 20);
}

}  // namespace
}  // namespace isthmus::storage
