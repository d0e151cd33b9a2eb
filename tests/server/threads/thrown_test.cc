// A store, and what it returns, that make libraries throw: named, left out, and the rest goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::server {
namespace {

using testing::Contains;
using testing::HasSubstr;

enum class Throws {
  kNever,
  kFeatures,
  kSubmaps,
  kWrites,
  kCheckpoints,
  kIsAway,
  kIsOftenAway,
  kHasNoSubmaps,
};

class ThrowingStore : public storage::ForwardingStore {
 public:
  ThrowingStore(std::unique_ptr<storage::MapStore> store,
                std::shared_ptr<std::atomic<Throws>> throws)
      : ForwardingStore(std::move(store)), throws_(std::move(throws)) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    if (*throws_ == Throws::kWrites && !batch.submaps.empty()) throw std::bad_alloc();
    return ForwardingStore::Write(batch);
  }
  absl::StatusOr<std::string> GetFeatures(const SubmapId& submap,
                                          const std::string& kind) const override {
    if (*throws_ == Throws::kFeatures) throw 7;  // No exception type is special.
    if (*throws_ == Throws::kIsAway) matches_ = true;
    return ForwardingStore::GetFeatures(submap, kind);
  }
  absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& submap) const override {
    if (*throws_ == Throws::kSubmaps) throw std::bad_alloc();
    if (*throws_ == Throws::kHasNoSubmaps) return absl::UnavailableError("no credentials");
    if (*throws_ == Throws::kIsOftenAway && ++asked_ % 4 != 0) {
      return absl::UnavailableError("the store is away");
    }
    // Every other time, once it is asked for what only matching reads.
    if (*throws_ == Throws::kIsAway && matches_ && ++asked_ % 2 == 1) {
      return absl::UnavailableError("the store is away");
    }
    return ForwardingStore::GetSubmap(submap);
  }
  bool IsRemote() const override { return true; }
  absl::StatusOr<storage::Checkpoint> GetCheckpoint(const SessionId& session) const override {
    if (*throws_ == Throws::kCheckpoints) throw std::bad_alloc();
    return ForwardingStore::GetCheckpoint(session);
  }

 private:
  const std::shared_ptr<std::atomic<Throws>> throws_;
  mutable std::atomic<bool> matches_ = false;
  mutable std::atomic<int> asked_ = 0;
};

class ThrownTest : public testing::Test {
 protected:
  // On what the last one stored.
  void Open() {
    pipeline_ = nullptr;
    std::filesystem::create_directories(folder_->path());
    PipelineOptions options = QuickOptions();
    options.submap_cache_bytes = 0;  // All are read.
    options.on_problem = [this](const std::string& problem) {
      MutexLock lock(&mutex_);
      problems_.push_back(problem);
    };
    auto pipeline =
        Pipeline::Open(options, std::make_unique<ThrowingStore>(
                                    storage::OpenSqliteStore(folder_->path()).value(), throws_));
    ASSERT_TRUE(pipeline.ok()) << pipeline.status();
    pipeline_ = *std::move(pipeline);
  }
  SessionId DriveFor(int scans, const std::string& robot, int number) {
    const SessionId session = pipeline_->sessions().Create({RobotId(robot), "vlp16"})->record.id;
    EXPECT_TRUE(drive_.Submit(*pipeline_, session, 0, scans, number).ok());
    return session;
  }
  std::vector<std::string> Problems() {
    MutexLock lock(&mutex_);
    return problems_;
  }

  std::unique_ptr<storage::TemporaryFolder> folder_ = std::make_unique<storage::TemporaryFolder>();
  const Drive drive_{2};
  const std::shared_ptr<std::atomic<Throws>> throws_ =
      std::make_shared<std::atomic<Throws>>(Throws::kNever);
  Mutex mutex_;
  std::vector<std::string> problems_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(ThrownTest, AMatchAtWhichSomethingIsThrownIsNamedAndLeftOut) {
  *throws_ = Throws::kFeatures;
  ASSERT_NO_FATAL_FAILURE(Open());
  for (int robot = 0; robot < 2; ++robot) {
    const SessionId session = DriveFor(6, robot == 0 ? "a" : "b", robot);
    EXPECT_TRUE(pipeline_->sessions().Finish(session).ok());
  }
  pipeline_->WaitUntilIdle();
  EXPECT_THAT(Problems(), Contains(HasSubstr("left out the match of a-1 and b-1")));
  EXPECT_TRUE(pipeline_->reader().GetMatchGraph().matches.empty());
  EXPECT_GT(pipeline_->reader().Map()->point_count(0), 0u);
}

TEST_F(ThrownTest, WithAStoreThatIsAwayForMomentsMapsAreMatchedWhole) {
  std::vector<Match> found;
  for (const Throws what : {Throws::kNever, Throws::kIsAway}) {
    *throws_ = what;
    pipeline_ = nullptr;
    folder_ = std::make_unique<storage::TemporaryFolder>();
    ASSERT_NO_FATAL_FAILURE(Open());
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session = DriveFor(40, robot == 0 ? "a" : "b", robot);
      EXPECT_TRUE(pipeline_->sessions().Finish(session).ok());
    }
    pipeline_->WaitUntilIdle();
    const std::vector<MatchEdge> matches = pipeline_->reader().GetMatchGraph().matches;
    ASSERT_EQ(matches.size(), 1u);
    found.push_back(matches[0].match);
  }
  EXPECT_GT(found[0].submaps_a, 5u);
  EXPECT_EQ(found[1].submaps_a, found[0].submaps_a);
  EXPECT_EQ(found[1].submaps_b, found[0].submaps_b);
  EXPECT_GE(found[0].overlap, 0);
  EXPECT_EQ(found[1].overlap, found[0].overlap);
  EXPECT_EQ(found[1].free_space, found[0].free_space);
}

TEST_F(ThrownTest, AfterAStartWithSuchAStoreTheMapIsWhole) {
  ASSERT_NO_FATAL_FAILURE(Open());
  EXPECT_TRUE(pipeline_->sessions().Finish(DriveFor(40, "a", 0)).ok());
  pipeline_->WaitUntilIdle();
  const uint64_t points = pipeline_->reader().Map()->point_count(0);
  EXPECT_GT(points, 1000u);
  *throws_ = Throws::kIsOftenAway;
  ASSERT_NO_FATAL_FAILURE(Open());
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(pipeline_->reader().Map()->point_count(0), points);
}

TEST_F(ThrownTest, WhatTheMapWaitsForIsToldUntilItComes) {
  ASSERT_NO_FATAL_FAILURE(Open());
  EXPECT_TRUE(pipeline_->sessions().Finish(DriveFor(40, "a", 0)).ok());
  pipeline_->WaitUntilIdle();
  const uint64_t points = pipeline_->reader().Map()->point_count(0);
  *throws_ = Throws::kHasNoSubmaps;
  ASSERT_NO_FATAL_FAILURE(Open());
  while (pipeline_->GetMapInfo().storage_problem.empty()) std::this_thread::yield();
  EXPECT_THAT(pipeline_->GetMapInfo().storage_problem, HasSubstr("no credentials"));
  *throws_ = Throws::kNever;
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(pipeline_->GetMapInfo().storage_problem, "");
  EXPECT_EQ(pipeline_->reader().Map()->point_count(0), points);
}

TEST_F(ThrownTest, WhatCannotBeReadAfterAStartIsNamedAndTheServerServes) {
  ASSERT_NO_FATAL_FAILURE(Open());
  const SessionId session = DriveFor(6, "a", 0);
  pipeline_->WaitUntilIdle();
  for (const Throws what : {Throws::kSubmaps, Throws::kCheckpoints}) {
    *throws_ = what;
    ASSERT_NO_FATAL_FAILURE(Open());
    pipeline_->WaitUntilIdle();
    const std::vector<std::string> problems = Problems();
    EXPECT_THAT(problems, Contains(HasSubstr("not enough memory")));
    EXPECT_EQ(pipeline_->reader().ListSubmaps(std::nullopt)->size(), 2u);
  }
  // Its checkpoint could not be read, so nobody knows where it goes on.
  const absl::Status refused = pipeline_->sessions().SubmitScan(session, drive_.Upload(6));
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("create a new session"));
  DriveFor(3, "b", 1);
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(pipeline_->reader().ListSubmaps(std::nullopt)->size(), 2u);
  *throws_ = Throws::kNever;
  ASSERT_NO_FATAL_FAILURE(Open());
  EXPECT_TRUE(pipeline_->sessions().SubmitScan(session, drive_.Upload(6)).ok());
}

TEST_F(ThrownTest, WhatCannotBeStoredIsOfferedAgain) {
  ASSERT_NO_FATAL_FAILURE(Open());
  *throws_ = Throws::kWrites;
  const SessionId session = DriveFor(6, "a", 0);
  pipeline_->WaitUntilIdle();
  EXPECT_THAT(pipeline_->GetMapInfo().storage_problem, HasSubstr("not enough memory"));
  EXPECT_EQ(pipeline_->sessions().Get(session)->durable_sequence, 0u);
  *throws_ = Throws::kNever;
  EXPECT_TRUE(pipeline_->sessions().Finish(session).ok());
  EXPECT_EQ(pipeline_->sessions().Get(session)->durable_sequence, 6u);
}

}  // namespace
}  // namespace isthmus::server
