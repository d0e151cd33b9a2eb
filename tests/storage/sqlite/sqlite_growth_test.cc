// A robot that goes round and round: submaps come and go, the file stays as large as it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

constexpr uint32_t kLive = 8;

// Submap `index` comes with its scans, features, a loop closure and a revision; the one that was
// there kLive submaps ago leaves.
WriteBatch Lap(const SessionId& session, uint32_t index) {
  const int64_t number = index + 1;
  WriteBatch batch{.submaps = {MakeSubmap(session.value(), index, 400)},
                   .revision = MakeRevision(number)};
  for (uint64_t scan = 0; scan < 10; ++scan) {
    batch.trajectory.emplace_back(session, MakeEntry(10 * index + scan));
  }
  if (index >= 1) {
    LoopClosure loop = MakeLoop(index, session.value());
    loop.submap_a = index - 1;
    loop.submap_b = index;
    loop.edges = {MakeEdge(index - 1, index)};
    batch.loops.push_back(loop);
    batch.revision->loops.push_back(index);
  }
  const auto at = Pose::FromXyzRpy(index % kLive, 0, 0, 0, 0, 0);
  for (uint32_t i = index - std::min(index, kLive - 1); i <= index; ++i) {
    SubmapMove move{.submap = {session, i}, .after = at, .frame_after = session};
    if (i < index) {
      move.before = at;
      move.frame_before = session;
    }
    batch.moves.push_back(move);
  }
  if (index >= kLive) {
    const SubmapId old{session, index - kLive};
    batch.retired = {old};
    batch.moves.push_back({.submap = old, .before = at, .frame_before = session});
  }
  return batch;
}

TEST(SqliteGrowthTest, StaysAsLargeAsItsSubmapsAre) {
  const TemporaryFolder folder;
  const SessionId alice("alice-1");
  const auto run = [&](uint32_t first, uint32_t end) {
    const auto store = OpenSqliteStore(folder.path(), {.sync_every_commit = false});
    ASSERT_TRUE(store.ok()) << store.status();
    // Replaced by itself from the second run on.
    ASSERT_TRUE((*store)->Write({.sessions = {MakeSession("alice-1")}}).ok());
    for (uint32_t i = first; i < end; ++i) {
      const absl::Status status = (*store)->Write(Lap(alice, i));
      ASSERT_TRUE(status.ok()) << status;
      const auto kept =
          (*store)->PutFeatures(MakeFeatures({alice, i}, "prepared", std::string(5000, 'p')));
      ASSERT_TRUE(kept.ok()) << kept;
    }
    EXPECT_EQ((*store)->ListSubmaps(alice)->size(), kLive);
    EXPECT_EQ((*store)->GetTrajectory(alice)->size(), 10 * kLive);
    EXPECT_EQ((*store)->ListLoops()->size(), kLive - 1);
  };
  // History has its own limit and fills up first.
  run(0, kRevisionsKept + 100);
  const auto before = std::filesystem::file_size(folder.database());
  run(kRevisionsKept + 100, 2 * kRevisionsKept + 100);
  const auto after = std::filesystem::file_size(folder.database());
  EXPECT_LT(after, before + before / 50);
}

}  // namespace
}  // namespace isthmus::storage
