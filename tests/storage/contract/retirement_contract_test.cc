// The promises of map_store.h about submaps that leave the map, held by every store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::ElementsAre;

class RetirementContract : public MapStoreContract {
 protected:
  void SetUp() override {
    MapStoreContract::SetUp();
    WriteBatch batch{.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
                     .matches = {MakeMatch("alice-1", "bob-1")}};
    for (uint32_t i = 0; i < 8; ++i) {
      batch.submaps.push_back(MakeSubmap("alice-1", i, 50));
      batch.submaps.push_back(MakeSubmap("bob-1", i, 50));
    }
    // Ten scans to a submap.
    for (uint64_t sequence = 0; sequence < 80; ++sequence) {
      batch.trajectory.emplace_back(alice_, MakeEntry(sequence));
      batch.trajectory.emplace_back(bob_, MakeEntry(sequence));
    }
    Put(batch);
  }

  std::vector<uint64_t> LoopIds() {
    std::vector<uint64_t> ids;
    const auto loops = store_->ListLoops();
    for (const LoopClosure& loop : *loops) ids.push_back(loop.id);
    return ids;
  }
};

TEST_P(RetirementContract, TakesAllThatWasKeptOfASubmap) {
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 3}, "fpfh", "x")).ok());
  Put({.anchors = {MakeAnchor("alice-1", 3), MakeAnchor("alice-1", 4), MakeAnchor("bob-1", 3)}});
  Put({.retired = {{alice_, 3}}});
  EXPECT_EQ(store_->GetSubmap({alice_, 3}).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetFeatures({alice_, 3}, "fpfh").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->ListSubmaps(alice_)->size(), 7u);
  const auto trajectory = store_->GetTrajectory(alice_);
  EXPECT_EQ(trajectory->size(), 70u);
  for (const TrajectoryEntry& entry : *trajectory) EXPECT_NE(entry.submap_index, 3u);
  ASSERT_EQ(store_->ListAnchors()->size(), 2u);
  EXPECT_EQ(store_->ListAnchors()->at(0).submap.index, 4u);
  // Nobody else's.
  EXPECT_EQ(store_->GetTrajectory(bob_)->size(), 80u);
  EXPECT_TRUE(store_->GetSubmap({bob_, 3}).ok());
  EXPECT_EQ(store_->ListMatches()->at(0).edges.size(), 2u);
}

TEST_P(RetirementContract, LeavesTheUnknownAsItIs) {
  Put({.retired = {{nobody_, 0}, {alice_, 99}}});
  EXPECT_EQ(store_->ListSubmaps(std::nullopt)->size(), 16u);
  Put({.retired = {{alice_, 1}, {alice_, 1}}});
  Put({.retired = {{alice_, 1}}});
  EXPECT_EQ(store_->ListSubmaps(std::nullopt)->size(), 15u);
  EXPECT_EQ(store_->GetTrajectory(alice_)->size(), 70u);
}

// MakeLoop's edges are between 0 and 5 and between 2 and 7.
TEST_P(RetirementContract, TakesLoopClosuresWithTheirLastWholeEdge) {
  LoopClosure single = MakeLoop(3, "alice-1");
  single.edges.pop_back();
  Put({.loops = {MakeLoop(1, "alice-1"), MakeLoop(2, "bob-1"), single}});
  Put({.retired = {{alice_, 1}}});
  EXPECT_THAT(LoopIds(), ElementsAre(1, 2, 3));
  Put({.retired = {{alice_, 5}}});
  EXPECT_THAT(LoopIds(), ElementsAre(1, 2));
  EXPECT_EQ(store_->ListLoops()->at(0).edges.size(), 2u);
  // A loop that is written anew stays as it is, as long as nothing more of it goes.
  Put({.loops = {MakeLoop(1, "alice-1")}});
  EXPECT_THAT(LoopIds(), ElementsAre(1, 2));
  Put({.retired = {{alice_, 2}}});
  EXPECT_THAT(LoopIds(), ElementsAre(2));
}

TEST_P(RetirementContract, IsPartOfItsBatch) {
  EXPECT_EQ(CodeOf({.retired = {{alice_, 0}}, .moves = {SubmapMove()}}),
            StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->GetSubmap({alice_, 0}).ok());
  Put({.submaps = {MakeSubmap("alice-1", 8, 50)}, .retired = {{alice_, 8}, {alice_, 0}}});
  EXPECT_EQ(store_->ListSubmaps(alice_)->size(), 7u);
  // Numbers are not given again by the server, but nothing is left that would be in their way.
  Put({.submaps = {MakeSubmap("alice-1", 0)}});
  EXPECT_TRUE(store_->GetSubmap({alice_, 0}).ok());
}

INSTANTIATE_TEST_SUITE_P(Stores, RetirementContract, ::testing::ValuesIn(StoresOfContract()),
                         NameOf);

}  // namespace
}  // namespace isthmus::storage
