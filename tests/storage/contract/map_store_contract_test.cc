// The promises of map_store.h, held by every store.
#include "tests/storage/contract/map_store_contract.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <thread>

#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

TEST_P(MapStoreContract, BeginsEmpty) {
  EXPECT_TRUE(store_->ListSessions()->empty());
  EXPECT_TRUE(store_->ListSubmaps(std::nullopt)->empty());
  EXPECT_TRUE(store_->ListMatches()->empty());
  EXPECT_EQ(store_->LatestRevision()->revision, 0);
  EXPECT_TRUE(store_->LatestRevision()->placements.empty());
  EXPECT_TRUE(store_->Write({}).ok());
}

TEST_P(MapStoreContract, DoesNotKnowTheUnknown) {
  EXPECT_EQ(store_->GetSession(nobody_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetTrajectory(nobody_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->ListSubmaps(nobody_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetSubmap({nobody_, 0}).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->StoredBytes(nobody_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->DeleteSession(nobody_).code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->PutFeatures(MakeFeatures({nobody_, 0}, "fpfh", "x")).code(),
            StatusCode::kNotFound);
  EXPECT_EQ(store_->GetFeatures({nobody_, 0}, "fpfh").status().code(), StatusCode::kNotFound);
}

TEST_P(MapStoreContract, KeepsAndReplacesSessionsInOrderOfCreation) {
  Put({.sessions = {MakeSession("bob-1", "bob"), MakeSession("alice-1")}});
  SessionRecord changed = MakeSession("bob-1", "bob");
  changed.state = SessionState::kFinished;
  changed.finished_ns = 1'700'000'009'000'000'001;
  changed.sensor = "hdl64";
  Put({.sessions = {changed}});
  const auto records = store_->ListSessions();
  ASSERT_EQ(records->size(), 2u);
  EXPECT_EQ((*records)[0].id, bob_);
  EXPECT_EQ((*records)[1].id, alice_);
  const auto bob = store_->GetSession(bob_);
  ASSERT_TRUE(bob.ok());
  EXPECT_EQ(bob->robot, RobotId("bob"));
  EXPECT_EQ(bob->sensor, "hdl64");
  EXPECT_EQ(bob->state, SessionState::kFinished);
  EXPECT_EQ(bob->created_ns, changed.created_ns);
  EXPECT_EQ(bob->finished_ns, changed.finished_ns);
  EXPECT_TRUE(Near(bob->T_base_sensor, changed.T_base_sensor));
}

TEST_P(MapStoreContract, ReplacingASessionKeepsWhatItHolds) {
  Put({.sessions = {MakeSession("alice-1")},
       .trajectory = {{alice_, MakeEntry(1)}},
       .submaps = {MakeSubmap("alice-1", 0)}});
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_EQ(store_->GetTrajectory(alice_)->size(), 1u);
  EXPECT_TRUE(store_->GetSubmap({alice_, 0}).ok());
}

TEST_P(MapStoreContract, AppendsTrajectoriesAndLeavesWhatIsThere) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")},
       .trajectory = {{alice_, MakeEntry(1)}, {bob_, MakeEntry(7)}, {alice_, MakeEntry(3)}}});
  TrajectoryEntry again = MakeEntry(3);
  again.stamp_ns = 5;
  Put({.trajectory = {{alice_, again}, {alice_, MakeEntry(2)}}});
  const auto entries = store_->GetTrajectory(alice_);
  ASSERT_EQ(entries->size(), 3u);
  for (uint64_t i = 0; i < 3; ++i) {
    const TrajectoryEntry expected = MakeEntry(i + 1);
    EXPECT_EQ((*entries)[i].sequence, expected.sequence);
    EXPECT_EQ((*entries)[i].stamp_ns, expected.stamp_ns);
    EXPECT_EQ((*entries)[i].submap_index, expected.submap_index);
    EXPECT_TRUE(Near((*entries)[i].T_odom_sensor, expected.T_odom_sensor));
  }
  EXPECT_EQ(store_->GetTrajectory(bob_)->size(), 1u);
}

TEST_P(MapStoreContract, KeepsSubmapsWithinTheirResolution) {
  const auto submap = MakeSubmap("alice-1", 2);
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {submap}});
  const auto back = store_->GetSubmap({alice_, 2});
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ((*back)->id, submap->id);
  EXPECT_EQ((*back)->robot, submap->robot);
  EXPECT_EQ((*back)->first_sequence, submap->first_sequence);
  EXPECT_EQ((*back)->last_sequence, submap->last_sequence);
  EXPECT_EQ((*back)->first_stamp_ns, submap->first_stamp_ns);
  EXPECT_EQ((*back)->last_stamp_ns, submap->last_stamp_ns);
  EXPECT_TRUE(Near((*back)->T_odom_submap, submap->T_odom_submap));
  EXPECT_EQ((*back)->drift_covariance, submap->drift_covariance);
  ASSERT_EQ((*back)->keyframes.size(), submap->keyframes.size());
  for (size_t k = 0; k < submap->keyframes.size(); ++k) {
    EXPECT_EQ((*back)->keyframes[k].sequence, submap->keyframes[k].sequence);
    EXPECT_EQ((*back)->keyframes[k].stamp_ns, submap->keyframes[k].stamp_ns);
    EXPECT_TRUE(Near((*back)->keyframes[k].T_submap_sensor, submap->keyframes[k].T_submap_sensor));
  }
  ASSERT_EQ((*back)->points.size(), submap->points.size());
  for (size_t i = 0; i < submap->points.size(); ++i) {
    const SubmapPoint &a = (*back)->points[i], &b = submap->points[i];
    EXPECT_LE((a.Position() - b.Position()).cwiseAbs().maxCoeff(), 0.00051f);
    EXPECT_EQ(a.intensity, b.intensity);
    EXPECT_EQ(a.keyframe, b.keyframe);
  }
}

TEST_P(MapStoreContract, ListsSubmapsWithoutTheirPoints) {
  Put({.sessions = {MakeSession("bob-1"), MakeSession("alice-1")},
       .submaps = {MakeSubmap("bob-1", 0), MakeSubmap("alice-1", 1), MakeSubmap("alice-1", 0)}});
  const auto all = store_->ListSubmaps(std::nullopt);
  ASSERT_EQ(all->size(), 3u);
  EXPECT_EQ((*all)[0].id, (SubmapId{alice_, 0}));
  EXPECT_EQ((*all)[1].id, (SubmapId{alice_, 1}));
  EXPECT_EQ((*all)[2].id, (SubmapId{bob_, 0}));
  const auto of_alice = store_->ListSubmaps(alice_);
  ASSERT_EQ(of_alice->size(), 2u);
  const SubmapInfo expected = Summarize(*MakeSubmap("alice-1", 1));
  const SubmapInfo& info = (*of_alice)[1];
  EXPECT_EQ(info.robot, expected.robot);
  EXPECT_EQ(info.last_sequence, expected.last_sequence);
  EXPECT_EQ(info.keyframe_count, expected.keyframe_count);
  EXPECT_EQ(info.point_count, expected.point_count);
  EXPECT_EQ(info.bounds.min, expected.bounds.min);
  EXPECT_EQ(info.bounds.max, expected.bounds.max);
  EXPECT_EQ(info.content, expected.content);
  EXPECT_NE(info.content, (*of_alice)[0].content);
}

TEST_P(MapStoreContract, TakesSubmapsWithoutPoints) {
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0, 0)}});
  EXPECT_TRUE((*store_->GetSubmap({alice_, 0}))->points.empty());
  EXPECT_TRUE((*store_->GetSubmap({alice_, 0}))->drift_covariance.isZero(0));
  EXPECT_TRUE((*store_->ListSubmaps(alice_))[0].bounds.empty());
}

TEST_P(MapStoreContract, KeepsTheLatestRevision) {
  Put({.revision = MakeRevision(3)});
  Put({.revision = MakeRevision(5)});
  EXPECT_EQ(CodeOf({.revision = MakeRevision(5)}), StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.revision = MakeRevision(4)}), StatusCode::kFailedPrecondition);
  const auto latest = store_->LatestRevision();
  const MapRevision expected = MakeRevision(5);
  EXPECT_EQ(latest->revision, 5);
  EXPECT_EQ(latest->stamp_ns, expected.stamp_ns);
  EXPECT_EQ(latest->cause, expected.cause);
  ASSERT_EQ(latest->placements.size(), 2u);
  EXPECT_EQ(latest->placements[1].session, bob_);
  EXPECT_EQ(latest->placements[1].reference, alice_);
  EXPECT_TRUE(Near(latest->placements[1].T_map_odom, expected.placements[1].T_map_odom));
}

TEST_P(MapStoreContract, KeepsFeaturesOfSubmaps) {
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}});
  EXPECT_EQ(store_->GetFeatures({alice_, 0}, "fpfh").status().code(), StatusCode::kNotFound);
  const std::string data("\0\xFFwhatever\n", 11);
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", "old")).ok());
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", data)).ok());
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 0}, "other", "")).ok());
  EXPECT_EQ(*store_->GetFeatures({alice_, 0}, "fpfh"), data);
  EXPECT_EQ(*store_->GetFeatures({alice_, 0}, "other"), "");
}

TEST_P(MapStoreContract, CountsWhatASessionTakesUp) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  EXPECT_EQ(*store_->StoredBytes(alice_), 0u);
  Put({.submaps = {MakeSubmap("alice-1", 0), MakeSubmap("bob-1", 0)}});
  const uint64_t one = *store_->StoredBytes(alice_);
  EXPECT_GT(one, 0u);
  Put({.submaps = {MakeSubmap("alice-1", 1)}});
  const uint64_t two = *store_->StoredBytes(alice_);
  EXPECT_GT(two, one);
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", std::string(1000, 'x'))).ok());
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 1}, "fpfh", std::string(500, 'x'))).ok());
  EXPECT_EQ(*store_->StoredBytes(alice_), two + 1500);
  EXPECT_EQ(*store_->StoredBytes(bob_), one);
  Put({.retired = {{alice_, 0}}});
  EXPECT_EQ(*store_->StoredBytes(alice_), two - one + 500);
}

TEST_P(MapStoreContract, KeepsTheLastManualDecisionOnEveryPairUntilItIsWithdrawn) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1"), MakeSession("carol-1")},
       .manual_decisions = {MakeManualDecision("alice-1", "carol-1"),
                            MakeManualDecision("alice-1", "bob-1")}});
  ManualDecision newer = MakeManualDecision("alice-1", "carol-1");
  newer.kind = ManualDecisionKind::kAccept;
  newer.note = "seen from the gallery";
  Put({.manual_decisions = {newer}});
  const auto manual_decisions = store_->ListManualDecisions();
  ASSERT_EQ(manual_decisions->size(), 2u);
  EXPECT_EQ((*manual_decisions)[0].b, bob_);
  const ManualDecision& manual_decision = (*manual_decisions)[1];
  EXPECT_EQ(manual_decision.a, alice_);
  EXPECT_EQ(manual_decision.kind, ManualDecisionKind::kAccept);
  EXPECT_EQ(manual_decision.note, newer.note);
  EXPECT_EQ(manual_decision.given_ns, newer.given_ns);
  EXPECT_TRUE(Near(manual_decision.T_a_b, newer.T_a_b));
  const std::pair<SessionId, SessionId> pair(manual_decision.a, manual_decision.b);
  Put({.withdrawn_decisions = {pair, pair, {bob_, manual_decision.b}}});
  ASSERT_EQ(store_->ListManualDecisions()->size(), 1u);
  ASSERT_TRUE(store_->DeleteSession(alice_).ok());
  EXPECT_TRUE(store_->ListManualDecisions()->empty());
}

TEST_P(MapStoreContract, WritesAllOrNothing) {
  Put({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}});
  const WriteBatch bad{.sessions = {MakeSession("bob-1")},
                       .trajectory = {{alice_, MakeEntry(1)}},
                       .submaps = {MakeSubmap("alice-1", 1), MakeSubmap("alice-1", 0)},
                       .matches = {MakeMatch("alice-1", "bob-1")},
                       .revision = MakeRevision(1)};
  EXPECT_EQ(CodeOf(bad), StatusCode::kAlreadyExists);
  EXPECT_EQ(store_->ListSessions()->size(), 1u);
  EXPECT_TRUE(store_->GetTrajectory(alice_)->empty());
  EXPECT_EQ(store_->ListSubmaps(alice_)->size(), 1u);
  EXPECT_TRUE(store_->ListMatches()->empty());
  EXPECT_EQ(store_->LatestRevision()->revision, 0);
}

TEST_P(MapStoreContract, RefusesWhatRefersToNothing) {
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_EQ(CodeOf({.submaps = {MakeSubmap("nobody-1", 0)}}), StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.trajectory = {{nobody_, MakeEntry(1)}}}), StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.matches = {MakeMatch("alice-1", "nobody-1")}}),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.manual_decisions = {MakeManualDecision("alice-1", "nobody-1")}}),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(CodeOf({.submaps = {MakeSubmap("alice-1", 0), MakeSubmap("alice-1", 0)}}),
            StatusCode::kAlreadyExists);
}

TEST_P(MapStoreContract, RefusesRecordsThatBreakTheirPromise) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  EXPECT_EQ(CodeOf({.sessions = {MakeSession("")}}), StatusCode::kInvalidArgument);
  EXPECT_EQ(CodeOf({.matches = {MakeMatch("bob-1", "alice-1")}}), StatusCode::kInvalidArgument);
  EXPECT_EQ(CodeOf({.manual_decisions = {MakeManualDecision("bob-1", "alice-1")}}),
            StatusCode::kInvalidArgument);
  auto submap = MakeSubmap("alice-1", 0);
  submap->points[7].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap = MakeSubmap("alice-1", 0);
  submap->points[7].x = 1e9f;
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap = MakeSubmap("alice-1", 0);
  submap->points[7].keyframe = 3;
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap = MakeSubmap("alice-1", 0);
  submap->keyframes.clear();
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap = MakeSubmap("alice-1", 0);
  submap->T_odom_submap = Pose(Eigen::Vector3d(0, std::nan(""), 0));
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap = MakeSubmap("alice-1", 0);
  submap->drift_covariance(2, 2) = -1;
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  submap->drift_covariance(2, 2) = std::nan("");
  EXPECT_EQ(CodeOf({.submaps = {submap}}), StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->ListSubmaps(std::nullopt)->empty());
}

TEST_P(MapStoreContract, DeletesASessionWithAllThatIsItsOwn) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1"), MakeSession("carol-1")},
       .trajectory = {{alice_, MakeEntry(1)}},
       .submaps = {MakeSubmap("alice-1", 0), MakeSubmap("bob-1", 0)},
       .matches = {MakeMatch("alice-1", "bob-1"), MakeMatch("bob-1", "carol-1")}});
  ASSERT_TRUE(store_->PutFeatures(MakeFeatures({alice_, 0}, "fpfh", "x")).ok());
  ASSERT_TRUE(store_->DeleteSession(alice_).ok());
  EXPECT_EQ(store_->GetSession(alice_).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetSubmap({alice_, 0}).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->GetFeatures({alice_, 0}, "fpfh").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(store_->ListSubmaps(std::nullopt)->size(), 1u);
  EXPECT_EQ(store_->ListMatches()->size(), 1u);
  // The name is free again, and nothing old comes back with it.
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_TRUE(store_->GetTrajectory(alice_)->empty());
  EXPECT_TRUE(store_->ListSubmaps(alice_)->empty());
  Put({.submaps = {MakeSubmap("alice-1", 0)}});
  EXPECT_EQ(store_->ListSessions()->back().id, alice_);
}

TEST_P(MapStoreContract, KeepsTheProgressOfMatchingBySession) {
  using Progress = std::vector<MatchingProgress>;
  EXPECT_EQ(*store_->ListMatchingProgress(), Progress());
  EXPECT_EQ(CodeOf({.matching_progress = {{alice_, 1}}}), StatusCode::kFailedPrecondition);
  const MatchingProgress alice{alice_, 7, 0xfffffffe, 20, 5, uint64_t{1} << 40};
  Put({.sessions = {MakeSession("bob-1"), MakeSession("alice-1"), MakeSession("carol-1")},
       .matching_progress = {{bob_, 1}, {alice_, 2}}});
  Put({.matching_progress = {alice}});
  EXPECT_EQ(*store_->ListMatchingProgress(), (Progress{alice, {bob_, 1}}));
  // It neither goes with a submap nor outlives its session.
  Put({.submaps = {MakeSubmap("bob-1", 0), MakeSubmap("bob-1", 1)}});
  Put({.retired = {{bob_, 0}}});
  ASSERT_TRUE(store_->DeleteSession(alice_).ok());
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_EQ(*store_->ListMatchingProgress(), (Progress{{bob_, 1}}));
}

TEST_P(MapStoreContract, ServesManyThreads) {
  Put({.sessions = {MakeSession("alice-1"), MakeSession("bob-1")}});
  std::atomic<int> failures = 0;
  const auto write = [&](const std::string& session) {
    for (uint32_t i = 0; i < 20; ++i) {
      const WriteBatch batch{.trajectory = {{SessionId(session), MakeEntry(i + 1)}},
                             .submaps = {MakeSubmap(session, i, 50)}};
      if (!store_->Write(batch).ok()) ++failures;
    }
  };
  // A submap and its pose come in one batch: a reader must never see one without the other.
  const auto read = [&] {
    for (int i = 0; i < 60; ++i) {
      const auto submaps = store_->ListSubmaps(alice_);
      const auto poses = store_->GetTrajectory(alice_);  // Later, so never fewer.
      if (!submaps.ok() || !poses.ok() || poses->size() < submaps->size()) ++failures;
      for (const SubmapInfo& info : *submaps) {
        if (!store_->GetSubmap(info.id).ok()) ++failures;
      }
    }
  };
  std::vector<std::thread> threads;
  threads.emplace_back(write, "alice-1");
  threads.emplace_back(write, "bob-1");
  for (int i = 0; i < 4; ++i) threads.emplace_back(read);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failures, 0);
  EXPECT_EQ(store_->ListSubmaps(std::nullopt)->size(), 40u);
}

INSTANTIATE_TEST_SUITE_P(Stores, MapStoreContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

}  // namespace
}  // namespace isthmus::storage
