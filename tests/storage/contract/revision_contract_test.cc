// The promises of map_store.h about revisions and their effects on submaps, held by every store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

class RevisionContract : public MapStoreContract {
 protected:
  static SubmapMove Added(const std::string& session, uint32_t index, double x) {
    return {.submap = {SessionId(session), index},
            .after = Pose::FromXyzRpy(x, 2, 3, 0.1, 0.2, 0.3),
            .frame_after = SessionId("alice-1")};
  }
  static SubmapMove Moved(const std::string& session, uint32_t index, double x, double to_x) {
    SubmapMove move = Added(session, index, to_x);
    move.before = Pose::FromXyzRpy(x, 2, 3, 0.1, 0.2, 0.3);
    move.frame_before = SessionId("alice-1");
    return move;
  }
  static SubmapMove Removed(const std::string& session, uint32_t index, double x) {
    SubmapMove move = Moved(session, index, x, x);
    move.after.reset();
    move.frame_after = SessionId();
    return move;
  }
  void Write(int64_t number, const std::vector<SubmapMove>& moves) {
    Put({.revision = MakeRevision(number), .moves = moves});
  }
};

TEST_P(RevisionContract, BeginsWithRevisionZero) {
  EXPECT_TRUE(store_->ListRevisions(10)->empty());
  EXPECT_TRUE(store_->ListMoves(0, 0)->empty());
  EXPECT_EQ(store_->ListMoves(0, 1).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->ListMoves(-1, 0).status().code(), StatusCode::kOutOfRange);
}

TEST_P(RevisionContract, KnowsWhereEverySubmapLies) {
  Write(1, {Added("alice-1", 0, 10), Added("bob-1", 4, 20), Added("alice-1", 1, 30)});
  Write(2, {Moved("alice-1", 1, 30, 31), Removed("bob-1", 4, 20), Added("bob-1", 3, 40)});
  Write(3, {});
  const auto latest = store_->LatestRevision();
  ASSERT_TRUE(latest.ok()) << latest.status();
  EXPECT_EQ(latest->revision, 3);
  ASSERT_EQ(latest->placements.size(), 2u);
  const auto& of_alice = latest->placements[0].submaps;
  ASSERT_EQ(of_alice.size(), 2u);
  EXPECT_EQ(of_alice[0].index, 0u);
  EXPECT_TRUE(Near(of_alice[0].T_map_submap, *Added("alice-1", 0, 10).after));
  EXPECT_EQ(of_alice[1].index, 1u);
  EXPECT_TRUE(Near(of_alice[1].T_map_submap, *Added("alice-1", 1, 31).after));
  const auto& of_bob = latest->placements[1].submaps;
  ASSERT_EQ(of_bob.size(), 1u);
  EXPECT_EQ(of_bob[0].index, 3u);
}

TEST_P(RevisionContract, TakesSubmapsFromTheMovesAlone) {
  MapRevision revision = MakeRevision(1);
  revision.placements[0].submaps = {{7, Pose()}};
  Put({.revision = revision, .moves = {Added("alice-1", 2, 5)}});
  const auto latest = store_->LatestRevision();
  ASSERT_EQ(latest->placements[0].submaps.size(), 1u);
  EXPECT_EQ(latest->placements[0].submaps[0].index, 2u);
}

TEST_P(RevisionContract, SaysWhatMadeARevisionAndWhatCameOfIt) {
  Write(1, {Added("alice-1", 0, 10), Added("alice-1", 1, 20), Added("bob-1", 0, 30)});
  MapRevision revision = MakeRevision(2);
  revision.cause = "loop 17";
  revision.matches = {{SessionId("bob-1"), SessionId("carol-1")}, {alice_, bob_}};
  revision.loops = {17, 4};
  SubmapMove elsewhere = Moved("bob-1", 0, 30, 500);  // From another frame: no length to speak of.
  elsewhere.frame_before = bob_;
  Put({.revision = revision,
       .moves = {Moved("alice-1", 0, 10, 10.5), Moved("alice-1", 1, 20, 21.25), elsewhere,
                 Added("alice-1", 2, 30)}});
  Write(3, {Removed("alice-1", 2, 30)});
  const auto infos = store_->ListRevisions(2);
  ASSERT_TRUE(infos.ok()) << infos.status();
  ASSERT_EQ(infos->size(), 2u);
  EXPECT_EQ((*infos)[0].revision, 3);
  EXPECT_EQ((*infos)[0].removed, 1u);
  EXPECT_EQ((*infos)[0].largest_move_m, 0);
  const RevisionInfo& info = (*infos)[1];
  EXPECT_EQ(info.revision, 2);
  EXPECT_EQ(info.stamp_ns, revision.stamp_ns);
  EXPECT_EQ(info.cause, "loop 17");
  EXPECT_EQ(info.matches, revision.matches);
  EXPECT_EQ(info.loops, revision.loops);
  EXPECT_EQ(info.added, 1u);
  EXPECT_EQ(info.moved, 3u);
  EXPECT_EQ(info.removed, 0u);
  EXPECT_NEAR(info.largest_move_m, 1.25, 1e-12);
  EXPECT_EQ(store_->ListRevisions(10)->size(), 3u);
  EXPECT_TRUE(store_->ListRevisions(0)->empty());
  EXPECT_TRUE(store_->ListRevisions(-1)->empty());
}

TEST_P(RevisionContract, TheLatestNamesWhatMadeIt) {
  MapRevision revision = MakeRevision(1);
  revision.matches = {{alice_, bob_}};
  revision.loops = {5};
  Put({.revision = revision});
  EXPECT_EQ(store_->LatestRevision()->matches, revision.matches);
  EXPECT_EQ(store_->LatestRevision()->loops, revision.loops);
}

TEST_P(RevisionContract, ListsMovesBetweenTwoRevisions) {
  Write(1, {Added("bob-1", 0, 10), Added("alice-1", 1, 20)});
  SubmapMove joined = Moved("bob-1", 0, 10, 15);
  joined.frame_before = bob_;
  Write(2, {joined});
  Write(3, {Removed("bob-1", 0, 15), Added("alice-1", 2, 30)});
  const auto all = store_->ListMoves(0, 3);
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->size(), 5u);
  EXPECT_EQ((*all)[0].second.submap, (SubmapId{alice_, 1}));
  EXPECT_EQ((*all)[1].second.submap, (SubmapId{bob_, 0}));
  EXPECT_FALSE((*all)[1].second.before);
  EXPECT_TRUE((*all)[1].second.frame_before.empty());
  const auto& [number, move] = (*all)[2];
  EXPECT_EQ(number, 2);
  EXPECT_TRUE(Near(*move.before, *joined.before));
  EXPECT_EQ(move.frame_before, bob_);
  EXPECT_TRUE(Near(*move.after, *joined.after));
  EXPECT_EQ(move.frame_after, alice_);
  EXPECT_EQ((*all)[3].second.submap, (SubmapId{alice_, 2}));
  EXPECT_FALSE((*all)[4].second.after);
  EXPECT_TRUE((*all)[4].second.frame_after.empty());
  EXPECT_EQ(store_->ListMoves(1, 2)->size(), 1u);
  EXPECT_EQ(store_->ListMoves(2, 3)->size(), 2u);
  EXPECT_TRUE(store_->ListMoves(3, 3)->empty());
  EXPECT_TRUE(store_->ListMoves(3, 1)->empty());
  EXPECT_EQ(store_->ListMoves(0, 4).status().code(), StatusCode::kNotFound);
}

TEST_P(RevisionContract, ForgetsRevisionsBeyondTheNewest) {
  for (int64_t i = 1; i <= kRevisionsKept + 5; ++i) Write(i, {Added("alice-1", 0, 1)});
  EXPECT_EQ(store_->ListRevisions(5000)->size(), static_cast<size_t>(kRevisionsKept));
  EXPECT_EQ(store_->ListRevisions(5000)->back().revision, 6);
  EXPECT_EQ(store_->ListMoves(5, kRevisionsKept + 5)->size(), static_cast<size_t>(kRevisionsKept));
  const auto older = store_->ListMoves(4, 10);
  EXPECT_EQ(older.status().code(), StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(older.status().message()), HasSubstr("revision 5"));
  EXPECT_EQ(store_->LatestRevision()->placements[0].submaps.size(), 1u);
}

TEST_P(RevisionContract, ForgetsRevisionsWholeWhenTheirMovesAreTooMany) {
  std::vector<SubmapMove> many;
  for (uint32_t i = 0; i < kMovesKept / 4 + 1; ++i) many.push_back(Added("alice-1", i, i));
  for (int64_t i = 1; i <= 5; ++i) Write(i, i % 2 == 1 ? many : std::vector<SubmapMove>());
  EXPECT_EQ(store_->ListRevisions(10)->size(), 5u);
  Write(6, many);  // The fourth: a few above the limit.
  EXPECT_EQ(store_->ListRevisions(10)->size(), 5u);
  EXPECT_EQ(store_->ListRevisions(10)->back().revision, 2);
  EXPECT_EQ(store_->ListMoves(0, 6).status().code(), StatusCode::kOutOfRange);
  EXPECT_EQ(store_->ListMoves(1, 3)->size(), many.size());
  EXPECT_EQ(store_->LatestRevision()->placements[0].submaps.size(), many.size());
}

TEST_P(RevisionContract, RefusesMovesThatCannotBe) {
  const auto code_of = [&](const std::vector<SubmapMove>& moves) {
    return CodeOf({.revision = MakeRevision(1), .moves = moves});
  };
  const SubmapMove good = Moved("alice-1", 0, 1, 2);
  EXPECT_EQ(CodeOf({.moves = {good}}), StatusCode::kInvalidArgument);  // Without a revision.
  EXPECT_EQ(code_of({good, good}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of({Moved("carol-1", 0, 1, 2)}), StatusCode::kInvalidArgument);  // Not placed.
  SubmapMove bad = good;
  bad.frame_after = bob_;  // Not where its session is placed.
  EXPECT_EQ(code_of({bad}), StatusCode::kInvalidArgument);
  bad = good;
  bad.before.reset();  // But still a frame.
  EXPECT_EQ(code_of({bad}), StatusCode::kInvalidArgument);
  bad = good;
  bad.frame_before = SessionId();
  EXPECT_EQ(code_of({bad}), StatusCode::kInvalidArgument);
  bad = good;
  bad.after = Pose(Eigen::Vector3d(std::nan(""), 0, 0));
  EXPECT_EQ(code_of({bad}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of({{.submap = {alice_, 0}}}), StatusCode::kInvalidArgument);
  MapRevision twice = MakeRevision(1);
  twice.placements.push_back(twice.placements.front());
  EXPECT_EQ(CodeOf({.revision = twice}), StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->ListRevisions(1)->empty());
  // A submap may leave with its session.
  EXPECT_EQ(code_of({good, Removed("carol-1", 0, 1)}), StatusCode::kOk);
}

INSTANTIATE_TEST_SUITE_P(Stores, RevisionContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

}  // namespace
}  // namespace isthmus::storage
