// Every store's promises about sessions with several segments.
#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

class SegmentContract : public MapStoreContract {
 protected:
  const SessionId second_{"alice-1.2"};
};

INSTANTIATE_TEST_SUITE_P(Stores, SegmentContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

SessionRecord MakeSegment(uint32_t number, const std::string& first = "alice-1") {
  SessionRecord record = MakeSession(SegmentId(SessionId(first), number).value());
  record.segment = number;
  record.first_segment = SessionId(first);
  return record;
}

TEST_P(SegmentContract, SayWhoseTheyAre) {
  SessionRecord first = MakeSession("alice-1");
  first.scans = {1000, 20, 3, 4};
  Put({.sessions = {first, MakeSegment(2)}});
  Put({.sessions = {MakeSegment(3)}});
  const auto records = store_->ListSessions();
  ASSERT_TRUE(records.ok()) << records.status();
  ASSERT_EQ(records->size(), 3u);
  EXPECT_EQ(records->at(0).segment, 1u);
  EXPECT_TRUE(records->at(0).first_segment.empty());
  EXPECT_EQ(records->at(0).scans, first.scans);
  EXPECT_EQ(records->at(2).id, SessionId("alice-1.3"));
  const auto second = store_->GetSession(second_);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->segment, 2u);
  EXPECT_EQ(second->first_segment, alice_);
  EXPECT_EQ(second->opened(), alice_);
  EXPECT_EQ(second->scans, ScanCounts());
  SessionRecord finished = *second;
  finished.state = SessionState::kFinished;
  Put({.sessions = {finished}});
  EXPECT_EQ(store_->GetSession(second_)->first_segment, alice_) << "a change keeps it";
}

TEST_P(SegmentContract, ComeWithTheirFirstStretchOrNotAtAll) {
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}});
  const Checkpoint checkpoint{alice_, 10, 10, std::string("c")};
  EXPECT_EQ(CodeOf({.sessions = {MakeSegment(2)},
                    .checkpoints = {checkpoint},
                    .submaps = {MakeSubmap("alice-1.2", 0), MakeSubmap("alice-1", 0)}}),
            StatusCode::kAlreadyExists);
  EXPECT_EQ(store_->GetSession(second_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetCheckpoint(alice_).status().code(), StatusCode::kNotFound);
  Put({.sessions = {MakeSegment(2)},
       .checkpoints = {checkpoint},
       .trajectory = {{second_, MakeEntry(11)}},
       .submaps = {MakeSubmap("alice-1.2", 0)}});
  EXPECT_EQ(store_->GetTrajectory(second_)->size(), 1u);
  EXPECT_EQ(store_->ListSubmaps(second_)->size(), 1u);
}

TEST_P(SegmentContract, AreNothingWithoutTheirSession) {
  EXPECT_EQ(CodeOf({.sessions = {MakeSegment(2)}}), StatusCode::kFailedPrecondition);
  // One that comes later in the batch is too late.
  EXPECT_EQ(CodeOf({.sessions = {MakeSegment(2), MakeSession("alice-1")}}),
            StatusCode::kFailedPrecondition);
  SessionRecord record = MakeSegment(2);
  record.segment = 1;
  EXPECT_EQ(CodeOf({.sessions = {MakeSession("alice-1"), record}}), StatusCode::kInvalidArgument);
  record = MakeSegment(2);
  record.first_segment = SessionId();
  EXPECT_EQ(CodeOf({.sessions = {MakeSession("alice-1"), record}}), StatusCode::kInvalidArgument);
  record.first_segment = record.id;
  EXPECT_EQ(CodeOf({.sessions = {record}}), StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->ListSessions()->empty());
}

TEST_P(SegmentContract, GoWithTheirSession) {
  Put({.sessions = {MakeSession("alice-1"), MakeSegment(2), MakeSession("alice-10"),
                    MakeSession("bob-1"), MakeSegment(2, "bob-1")},
       .trajectory = {{second_, MakeEntry(11)}},
       .submaps = {MakeSubmap("alice-1.2", 0), MakeSubmap("bob-1.2", 0)},
       .matches = {MakeMatch("alice-1", "alice-1.2"), MakeMatch("alice-1.2", "bob-1"),
                   MakeMatch("alice-10", "bob-1")},
       .manual_decisions = {MakeManualDecision("alice-1.2", "bob-1")}});
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({second_, 0}, "fpfh", "x")).ok());
  ASSERT_TRUE(store_->DeleteSession(alice_).ok());
  EXPECT_EQ(store_->GetSession(second_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetSubmap({second_, 0}).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->ListSessions()->size(), 3u);
  EXPECT_EQ(store_->ListSubmaps(std::nullopt)->size(), 1u);
  EXPECT_EQ(store_->ListMatches()->size(), 1u);
  EXPECT_TRUE(store_->ListManualDecisions()->empty());
  // One alone goes alone.
  ASSERT_TRUE(store_->DeleteSession(SessionId("bob-1.2")).ok());
  EXPECT_TRUE(store_->GetSession(bob_).ok());
}

}  // namespace
}  // namespace isthmus::storage
