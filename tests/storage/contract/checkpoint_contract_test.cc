// Every store's promises about checkpoints.
#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

class CheckpointContract : public MapStoreContract {
 protected:
  void SetUp() override {
    MapStoreContract::SetUp();
    Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  }
};

INSTANTIATE_TEST_SUITE_P(Stores, CheckpointContract, ::testing::ValuesIn(StoresOfContract()),
                         NameOf);

Checkpoint MakeCheckpoint(const std::string& session, uint64_t sequence, uint64_t durable) {
  return {SessionId(session), sequence, durable, std::string(100'000, 'c') + '\0' + session};
}

TEST_P(CheckpointContract, IsReplacedBySession) {
  EXPECT_EQ(store_->GetCheckpoint(alice_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetCheckpoint(nobody_).status().code(), StatusCode::kNotFound);
  Put({.checkpoints = {MakeCheckpoint("alice-1", 10, 7), MakeCheckpoint("bob-1", 3, 3)}});
  Put({.checkpoints = {MakeCheckpoint("alice-1", 20, 20)}, .submaps = {MakeSubmap("alice-1", 0)}});
  const auto alice = store_->GetCheckpoint(alice_), bob = store_->GetCheckpoint(bob_);
  ASSERT_TRUE(alice.ok() && bob.ok()) << alice.status() << bob.status();
  EXPECT_EQ(alice->session, alice_);
  EXPECT_EQ(alice->sequence, 20u);
  EXPECT_EQ(alice->durable_sequence, 20u);
  EXPECT_EQ(alice->data, MakeCheckpoint("alice-1", 20, 20).data);
  EXPECT_EQ(bob->sequence, 3u);
  EXPECT_EQ(bob->data, MakeCheckpoint("bob-1", 3, 3).data);
}

TEST_P(CheckpointContract, ComesWithItsBatchOrNotAtAll) {
  Put({.submaps = {MakeSubmap("alice-1", 0)}});
  const WriteBatch twice{.checkpoints = {MakeCheckpoint("alice-1", 10, 10)},
                         .submaps = {MakeSubmap("alice-1", 0)}};
  EXPECT_EQ(CodeOf(twice), StatusCode::kAlreadyExists);
  EXPECT_EQ(store_->GetCheckpoint(alice_).status().code(), StatusCode::kNotFound);
}

TEST_P(CheckpointContract, IsRefusedWithoutItsSessionOrItsData) {
  EXPECT_EQ(CodeOf({.checkpoints = {MakeCheckpoint("nobody-1", 1, 1)}}),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.checkpoints = {MakeCheckpoint("alice-1", 1, 2)}}),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(CodeOf({.checkpoints = {{alice_, 1, 1}}}), StatusCode::kInvalidArgument);
  Put({.sessions = {MakeSession("nobody-1")}, .checkpoints = {MakeCheckpoint("nobody-1", 1, 1)}});
}

TEST_P(CheckpointContract, GoesWithItsSessionAndWhenThatIsFinished) {
  Put({.checkpoints = {MakeCheckpoint("alice-1", 10, 7), MakeCheckpoint("bob-1", 3, 3)}});
  SessionRecord finished = MakeSession("alice-1");
  Put({.sessions = {finished}});  // Still active.
  EXPECT_TRUE(store_->GetCheckpoint(alice_).ok());
  finished.state = SessionState::kFinished;
  Put({.sessions = {finished}, .checkpoints = {MakeCheckpoint("alice-1", 11, 11)}});
  EXPECT_EQ(store_->GetCheckpoint(alice_).status().code(), StatusCode::kNotFound);
  EXPECT_TRUE(store_->GetCheckpoint(bob_).ok());
  ASSERT_TRUE(store_->DeleteSession(bob_).ok());
  Put({.sessions = {MakeSession("bob-1")}});
  EXPECT_EQ(store_->GetCheckpoint(bob_).status().code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace isthmus::storage
