// A store that fails for a while: said, lived with, and over by itself.
#include "server/threads/store_health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/server/pipeline/robots.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(StoreHealthTest, SaysWhatFailsAndSinceWhenUntilAWriteSucceeds) {
  ManualClock clock(0);
  std::vector<std::string> told;
  StoreHealth health(&clock, [&](bool, const std::string& words) { told.push_back(words); });
  health.NoteWrite(absl::OkStatus());
  EXPECT_EQ(health.Problem(), "");
  health.NoteWrite(absl::ResourceExhaustedError("disk is full"));
  EXPECT_THAT(health.Problem(), HasSubstr("disk is full (since 00:00:00 UTC on 1970-01-01)"));
  clock.Advance(5'000'000'000);
  health.NoteWrite(absl::ResourceExhaustedError("disk is full"));
  EXPECT_THAT(health.Problem(), HasSubstr("since 00:00:00"));
  health.NoteWrite(absl::OkStatus());
  EXPECT_EQ(health.Problem(), "");
  EXPECT_THAT(told, ElementsAre(HasSubstr("disk is full"), HasSubstr("after 5 s")));
}

TEST(StoreHealthTest, WhatIsWrongWithABatchSaysNothingOfTheStore) {
  const ManualClock clock(0);
  StoreHealth health(&clock, nullptr);
  health.NoteWrite(absl::AlreadyExistsError("submap"));
  health.NoteWrite(absl::InvalidArgumentError("pose"));
  health.NoteWrite(absl::NotFoundError("session"));
  EXPECT_EQ(health.Problem(), "");
  health.NoteWrite(absl::UnavailableError("disk I/O error"));
  health.NoteWrite(absl::NotFoundError("session"));
  EXPECT_NE(health.Problem(), "");
}

// A bucket that is away, and a database that is there.
TEST(StoreHealthTest, WhileWhatIsLargeFailsItIsNoMatterWhatElseCanBeWritten) {
  ManualClock clock(0);
  std::vector<std::string> told;
  StoreHealth health(&clock, [&](bool, const std::string& words) { told.push_back(words); });
  health.NoteWrite(absl::UnavailableError("bucket away"), /*is_large=*/true);
  clock.Advance(15'000'000'000);
  health.NoteWrite(absl::OkStatus());
  EXPECT_THAT(health.Problem(), HasSubstr("bucket away"));
  health.NoteWrite(absl::UnavailableError("bucket away"), /*is_large=*/true);
  clock.Advance(15'000'000'000);
  health.NoteWrite(absl::OkStatus());
  EXPECT_THAT(health.Problem(), HasSubstr("since 00:00:00"));
  health.NoteWrite(absl::OkStatus(), /*is_large=*/true);
  EXPECT_EQ(health.Problem(), "");
  // Given up, as those of a session that was deleted are.
  health.NoteWrite(absl::UnavailableError("bucket away"), /*is_large=*/true);
  clock.Advance(25'000'000'000);
  health.NoteWrite(absl::OkStatus());
  EXPECT_EQ(health.Problem(), "");
  EXPECT_EQ(told.size(), 4u);
}

class FailingStoreTest : public testing::Test {
 protected:
  FailingStoreTest()
      : pipeline_(Pipeline::Open(QuickOptions(),
                                 storage::MakeFaultyStore(storage::MakeMemoryStore(), faults_))
                      .value()) {
    SessionRequest request;
    request.robot = RobotId("alice");
    request.sensor = "vlp16";
    session_ = pipeline_->sessions().Create(request)->record.id;
  }

  // The server's own retries come every second.
  bool EndsWithin(double seconds, const std::function<bool()>& holds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!holds()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  AckLog log_;
  const std::shared_ptr<storage::Faults> faults_ = std::make_shared<storage::Faults>();
  const std::unique_ptr<Pipeline> pipeline_;
  SessionId session_;
};

TEST_F(FailingStoreTest, AFullDiskIsSaidAndWhatWaitedIsStoredWithoutFurtherScans) {
  const Drive drive;
  ASSERT_TRUE(pipeline_->sessions().SetAckSink(session_, log_.Sink()).ok());
  faults_->SetDiskFull(true);
  ASSERT_TRUE(drive.Submit(*pipeline_, session_, 0, 7).ok());
  ASSERT_TRUE(
      EndsWithin(60, [&] { return pipeline_->sessions().Get(session_)->last_sequence == 7; }));
  ASSERT_TRUE(EndsWithin(60, [&] { return !pipeline_->GetMapInfo().storage_problem.empty(); }));
  EXPECT_EQ(pipeline_->sessions().Get(session_)->durable_sequence, 0u);
  EXPECT_TRUE(pipeline_->reader().ListSubmaps(std::nullopt).ok());

  faults_->SetDiskFull(false);
  EXPECT_TRUE(EndsWithin(60, [&] { return pipeline_->GetMapInfo().storage_problem.empty(); }));
  EXPECT_TRUE(
      EndsWithin(60, [&] { return pipeline_->sessions().Get(session_)->durable_sequence >= 5; }));
  // The robot, which pushes nothing more, is told.
  EXPECT_TRUE(EndsWithin(60, [&] {
    const std::vector<ScanAck> acks = log_.Take();
    return !acks.empty() && acks.back().durable_sequence >= 5;
  }));
}

TEST_F(FailingStoreTest, ItIsFoundOutThatTheDiskWorksAgainThoughNothingWaits) {
  faults_->FailWrites(1, absl::UnavailableError("disk I/O error"));
  SessionRequest request;
  request.robot = RobotId("bob");
  request.sensor = "vlp16";
  EXPECT_FALSE(pipeline_->sessions().Create(request).ok());
  EXPECT_THAT(pipeline_->GetMapInfo().storage_problem, HasSubstr("disk I/O error"));
  EXPECT_TRUE(EndsWithin(60, [&] { return pipeline_->GetMapInfo().storage_problem.empty(); }));
}

}  // namespace
}  // namespace isthmus::server
