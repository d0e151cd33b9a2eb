#include "tests/storage/faulty_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "storage/memory_store.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

class FaultyStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(store_->Write({.sessions = {MakeSession("alice-1")}}).ok()); }
  absl::Status Append(uint64_t sequence) {
    return store_->Write({.trajectory = {{alice_, MakeEntry(sequence)}}});
  }
  size_t Scans() const { return store_->GetTrajectory(alice_)->size(); }

  const SessionId alice_{"alice-1"};
  const std::shared_ptr<Faults> faults_ = std::make_shared<Faults>(7);
  const std::unique_ptr<MapStore> store_ = MakeFaultyStore(MakeMemoryStore(), faults_);
};

TEST_F(FaultyStoreTest, AFullDiskTakesNothingAndServesReaders) {
  faults_->SetDiskFull(true);
  EXPECT_EQ(Append(1).code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(store_->DeleteSession(alice_).code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(store_->PutFeatures(MakeFeatures({alice_, 0}, "k", "x")).code(),
            StatusCode::kResourceExhausted);
  EXPECT_EQ(store_->ListSessions()->size(), 1u);
  EXPECT_EQ(Scans(), 0u);
  faults_->SetDiskFull(false);
  EXPECT_TRUE(Append(1).ok());
  EXPECT_EQ(Scans(), 1u);
  EXPECT_EQ(faults_->failed_writes(), 3);
}

TEST_F(FaultyStoreTest, FailsAsOftenAsAskedFor) {
  faults_->FailWrites(2, absl::DataLossError("torn"));
  EXPECT_EQ(Append(1).code(), StatusCode::kDataLoss);
  EXPECT_EQ(Append(1).code(), StatusCode::kDataLoss);
  EXPECT_TRUE(Append(1).ok());
}

TEST_F(FaultyStoreTest, FailsAtTheSameMomentsWithTheSameSeed) {
  const auto outcomes = [](uint32_t seed) {
    const auto faults = std::make_shared<Faults>(seed);
    faults->SetFailureRate(0.3);
    const auto store = MakeFaultyStore(MakeMemoryStore(), faults);
    std::string text;
    for (int i = 0; i < 200; ++i) text += store->Write({}).ok() ? '+' : '-';
    EXPECT_EQ(std::count(text.begin(), text.end(), '-'), faults->failed_writes());
    return text;
  };
  const std::string first = outcomes(1);
  EXPECT_EQ(first, outcomes(1));
  EXPECT_NE(first, outcomes(2));
  EXPECT_NEAR(static_cast<double>(std::count(first.begin(), first.end(), '-')), 60, 25);
}

TEST_F(FaultyStoreTest, DamagesOneSubmapOrAllReads) {
  ASSERT_TRUE(
      store_->Write({.submaps = {MakeSubmap("alice-1", 0), MakeSubmap("alice-1", 1)}}).ok());
  faults_->Damage({alice_, 0});
  EXPECT_EQ(store_->GetSubmap({alice_, 0}).status().code(), StatusCode::kDataLoss);
  EXPECT_TRUE(store_->GetSubmap({alice_, 1}).ok());
  EXPECT_EQ(store_->ListSubmaps(alice_)->size(), 2u);
  faults_->FailReads(absl::UnavailableError("unplugged"));
  EXPECT_EQ(store_->ListSessions().status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(store_->GetSubmap({alice_, 1}).status().code(), StatusCode::kUnavailable);
  faults_->FailReads(absl::OkStatus());
  EXPECT_TRUE(store_->GetSubmap({alice_, 1}).ok());
}

TEST_F(FaultyStoreTest, StallsUntilResumed) {
  faults_->Stall();
  const int64_t before = faults_->writes();
  std::atomic<bool> is_written = false;
  std::thread writer([&] { is_written = Append(1).ok(); });
  while (faults_->writes() == before) std::this_thread::yield();
  EXPECT_EQ(Scans(), 0u);  // Readers do not wait for it.
  EXPECT_FALSE(is_written);
  faults_->Resume();
  writer.join();
  EXPECT_TRUE(is_written);
  faults_->SetSlowest(std::chrono::microseconds(100));
  EXPECT_TRUE(Append(2).ok());
  EXPECT_EQ(Scans(), 2u);
}

}  // namespace
}  // namespace isthmus::storage
