// The promises of map_store.h about loop closures and anchors, held by every store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class LoopContract : public MapStoreContract {};

TEST_P(LoopContract, KeepsTheLastOfEveryLoopClosure) {
  LoopClosure old = MakeLoop(2, "alice-1");
  old.detail = "an earlier run";
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
       .loops = {MakeLoop(7, "bob-1"), old}});
  LoopClosure expected = MakeLoop(2, "alice-1");
  expected.rejected = true;
  expected.residual_m = -1;
  Put({.loops = {expected}});
  const auto loops = store_->ListLoops();
  ASSERT_TRUE(loops.ok()) << loops.status();
  ASSERT_EQ(loops->size(), 2u);
  EXPECT_EQ((*loops)[1].id, 7u);
  EXPECT_EQ((*loops)[1].session, bob_);
  EXPECT_FALSE((*loops)[1].rejected);
  const LoopClosure& loop = (*loops)[0];
  EXPECT_EQ(loop.id, 2u);
  EXPECT_EQ(loop.session, alice_);
  EXPECT_EQ(loop.submap_a, expected.submap_a);
  EXPECT_EQ(loop.submap_b, expected.submap_b);
  EXPECT_TRUE(Near(loop.T_a_b, expected.T_a_b));
  EXPECT_EQ(loop.confidence, expected.confidence);
  EXPECT_EQ(loop.overlap, expected.overlap);
  EXPECT_EQ(loop.residual_m, -1);
  EXPECT_EQ(loop.free_space, expected.free_space);
  EXPECT_EQ(loop.comparisons, expected.comparisons);
  EXPECT_EQ(loop.source, expected.source);
  EXPECT_EQ(loop.detail, expected.detail);
  EXPECT_EQ(loop.computed_ns, expected.computed_ns);
  EXPECT_TRUE(loop.rejected);
  EXPECT_EQ(loop.note, expected.note);
  ASSERT_EQ(loop.edges.size(), 2u);
  EXPECT_EQ(loop.edges[1].submap_a, 2u);
  EXPECT_EQ(loop.edges[1].submap_b, 7u);
  EXPECT_TRUE(Near(loop.edges[1].T_a_b, expected.edges[1].T_a_b));
  EXPECT_EQ(loop.edges[1].information, expected.edges[1].information);
}

TEST_P(LoopContract, RefusesLoopClosuresThatAreNone) {
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_EQ(CodeOf({.loops = {MakeLoop(1, "nobody-1")}}), StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.loops = {MakeLoop(0, "alice-1")}}), StatusCode::kInvalidArgument);
  const auto code_of = [&](auto change) {
    LoopClosure loop = MakeLoop(1, "alice-1");
    change(loop);
    return CodeOf({.loops = {loop}});
  };
  EXPECT_EQ(code_of([](auto& loop) { loop.edges.clear(); }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& loop) { loop.submap_b = 6; }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& loop) { loop.edges[1].submap_a = 7; }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& loop) { loop.T_a_b = Pose(Eigen::Vector3d(0, kNaN, 0)); }),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& loop) { loop.edges[1].information(3, 3) = kNaN; }),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& loop) { loop.edges[1].information(2, 3) += 1; }),
            StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->ListLoops()->empty());
  EXPECT_EQ(code_of([](auto&) {}), StatusCode::kOk);
}

TEST_P(LoopContract, KeepsTheLastAnchorOfEverySubmap) {
  Put({.sessions = {MakeSession("bob-1"), MakeSession("alice-1")},
       .submaps = {MakeSubmap("bob-1", 0), MakeSubmap("alice-1", 4), MakeSubmap("alice-1", 2)},
       .anchors = {MakeAnchor("bob-1", 0), MakeAnchor("alice-1", 4), MakeAnchor("alice-1", 2)}});
  Anchor expected = MakeAnchor("alice-1", 4);
  expected.sigma_deg = 0.5;
  expected.sigma_z_m = 0;
  Put({.anchors = {expected}, .removed_anchors = {{bob_, 0}, {bob_, 3}, {nobody_, 0}}});
  const auto anchors = store_->ListAnchors();
  ASSERT_TRUE(anchors.ok()) << anchors.status();
  ASSERT_EQ(anchors->size(), 2u);
  EXPECT_EQ((*anchors)[0].submap, (SubmapId{alice_, 2}));
  const Anchor& anchor = (*anchors)[1];
  EXPECT_EQ(anchor.submap, (SubmapId{alice_, 4}));
  EXPECT_TRUE(Near(anchor.T_map_submap, expected.T_map_submap));
  EXPECT_EQ(anchor.sigma_xy_m, expected.sigma_xy_m);
  EXPECT_EQ(anchor.sigma_z_m, 0);
  EXPECT_EQ(anchor.sigma_deg, 0.5);
  EXPECT_EQ(anchor.note, expected.note);
  EXPECT_EQ(anchor.given_ns, expected.given_ns);
}

TEST_P(LoopContract, KeepsTheLastDatum) {
  EXPECT_EQ(*store_->GetDatum(), std::nullopt);
  const Datum first{.latitude_deg = 48, .longitude_deg = 11, .altitude_m = 520, .given_ns = 1};
  const Datum second{.latitude_deg = -33.9, .longitude_deg = 151.2, .heading_deg = 90.5};
  ASSERT_TRUE(store_->Write({.datum = first}).ok());
  ASSERT_TRUE(store_->Write({.datum = second}).ok());
  ASSERT_TRUE(store_->Write({}).ok()) << "what says nothing of it leaves it";
  const auto kept = store_->GetDatum();
  ASSERT_TRUE(kept.ok() && *kept);
  EXPECT_EQ((*kept)->latitude_deg, -33.9);
  EXPECT_EQ((*kept)->longitude_deg, 151.2);
  EXPECT_EQ((*kept)->heading_deg, 90.5);
  EXPECT_EQ(CodeOf({.datum = Datum{.latitude_deg = 91}}), StatusCode::kInvalidArgument);
  ASSERT_TRUE(store_->Write({.datum = std::optional<Datum>()}).ok());
  EXPECT_FALSE(store_->GetDatum()->has_value());
}

TEST_P(LoopContract, RefusesAnchorsThatHoldNothing) {
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}});
  EXPECT_EQ(CodeOf({.anchors = {MakeAnchor("alice-1", 1)}}), StatusCode::kFailedPrecondition);
  // One that comes in the same batch is there.
  EXPECT_EQ(CodeOf({.submaps = {MakeSubmap("alice-1", 1)}, .anchors = {MakeAnchor("alice-1", 1)}}),
            StatusCode::kOk);
  const auto code_of = [&](auto change) {
    Anchor anchor = MakeAnchor("alice-1", 0);
    change(anchor);
    return CodeOf({.anchors = {anchor}});
  };
  EXPECT_EQ(code_of([](auto& a) { a.sigma_xy_m = a.sigma_z_m = 0; }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& a) { a.sigma_z_m = -1; }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& a) { a.sigma_deg = kNaN; }), StatusCode::kInvalidArgument);
  EXPECT_EQ(code_of([](auto& a) { a.T_map_submap = Pose(Eigen::Vector3d(kNaN, 0, 0)); }),
            StatusCode::kInvalidArgument);
  const auto far = [](auto& a) { a.T_map_submap = Pose(Eigen::Vector3d(20'001, 0, 0)); };
  EXPECT_EQ(code_of(far), StatusCode::kInvalidArgument);
  EXPECT_EQ(store_->ListAnchors()->size(), 1u);
  // Unknown parts of an anchor are not looked at.
  EXPECT_EQ(code_of([&](auto& a) {
              far(a);
              a.sigma_xy_m = 0;
            }),
            StatusCode::kOk);
}

TEST_P(LoopContract, LosesThemWithTheirSession) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
       .submaps = {MakeSubmap("alice-1", 0), MakeSubmap("bob-1", 0)},
       .loops = {MakeLoop(1, "alice-1"), MakeLoop(2, "bob-1")},
       .anchors = {MakeAnchor("alice-1", 0), MakeAnchor("bob-1", 0)}});
  ASSERT_TRUE(store_->DeleteSession(alice_).ok());
  ASSERT_EQ(store_->ListLoops()->size(), 1u);
  EXPECT_EQ(store_->ListLoops()->at(0).id, 2u);
  ASSERT_EQ(store_->ListAnchors()->size(), 1u);
  EXPECT_EQ(store_->ListAnchors()->at(0).submap.session, bob_);
}

INSTANTIATE_TEST_SUITE_P(Stores, LoopContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

}  // namespace
}  // namespace isthmus::storage
