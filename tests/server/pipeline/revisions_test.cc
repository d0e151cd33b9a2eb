// Every change of the map is a revision that says what came of what, and can be gone back on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

// A stretch of a straight drive along a wall, 5 m long.
Submap WallSubmap(const SessionId& session, uint32_t index) {
  Submap submap;
  submap.id = {session, index};
  submap.T_odom_submap = Pose::FromXyzRpy(5.0 * index, 0.1 * index, 0, 0, 0, 0.02 * index);
  const int64_t start = 1'000'000'000 * (1 + int64_t{index});
  for (int k = 0; k < 5; ++k) {
    submap.keyframes.push_back({0, start + k * 100'000'000, Pose(Eigen::Vector3d(k, 0, 0))});
  }
  submap.first_stamp_ns = start;
  submap.last_stamp_ns = submap.keyframes.back().stamp_ns;
  for (int i = 0; i < 400; ++i) {
    submap.points.push_back({0.3f * (i % 20), 3.f, 0.2f * (i / 20), 1.f, uint16_t(i * 5 / 400)});
  }
  return submap;
}

class PipelineRevisions : public testing::Test {
 protected:
  PipelineRevisions() {
    for (const RobotId& robot : {kAlice, kBob}) {
      sessions_.push_back(pipeline_->sessions().Create({robot, "vlp16"}).value().record.id);
      for (uint32_t i = 0; i < 3; ++i) EXPECT_TRUE(Add(sessions_.back(), i).ok());
    }
    pipeline_->WaitUntilIdle();
  }

  absl::StatusOr<SubmapInfo> Add(const SessionId& session, uint32_t index) {
    return pipeline_->sessions().AddSubmap(WallSubmap(session, index));
  }
  Trajectory PathOf(const RobotId& robot) {
    return pipeline_->reader().GetTrajectory(robot, TrajectoryFrame::kMap).value().poses;
  }
  int64_t Revision() { return pipeline_->GetMapInfo().revision; }
  absl::Status Set(const Pose& T_a_b) {
    return pipeline_->decisions()
        .DecideMatch(
            {.robot_a = kAlice, .robot_b = kBob, .kind = ManualDecisionKind::kSet, .T_a_b = T_a_b})
        .status();
  }

  static PipelineOptions Options() {
    PipelineOptions options = QuickOptions();
    options.loops.enabled = false;
    return options;
  }

  std::unique_ptr<Pipeline> pipeline_ = OpenInMemory(Options());
  std::vector<SessionId> sessions_;
};

double LargestDifference(const Trajectory& a, const Trajectory& b) {
  if (a.size() != b.size()) return INFINITY;
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].pose.translation() - b[i].pose.translation()).norm());
  }
  return largest;
}

TEST_F(PipelineRevisions, ANewSubmapMakesOneThatNamesIt) {
  const int64_t before = Revision();
  ASSERT_TRUE(Add(sessions_[0], 3).ok());
  pipeline_->WaitUntilIdle();
  ASSERT_GT(Revision(), before);
  const RevisionDiff diff = pipeline_->reader().DiffRevisions(before, 0).value();
  EXPECT_EQ(diff.to, Revision());
  ASSERT_EQ(diff.moves.size(), 1u);
  EXPECT_EQ(diff.moves[0].submap, (SubmapId{sessions_[0], 3}));
  EXPECT_FALSE(diff.moves[0].before);
  ASSERT_TRUE(diff.moves[0].after);
  EXPECT_THAT(diff.revisions.back().cause, HasSubstr("alice-1/3"));
  EXPECT_EQ(diff.revisions.back().added, 1u);
  EXPECT_EQ(pipeline_->reader().Map()->revision(), Revision());
}

TEST_F(PipelineRevisions, AMatchByHandIsFollowedAndUndone) {
  const Trajectory alice = PathOf(kAlice), bob = PathOf(kBob);
  const int64_t before = Revision();
  ASSERT_TRUE(Set(Pose::FromXyzRpy(40, 7, 0, 0, 0, 1)).ok());
  pipeline_->WaitUntilIdle();
  const int64_t wrong = Revision();
  const RevisionDiff diff = pipeline_->reader().DiffRevisions(before, wrong).value();
  EXPECT_EQ(diff.moves.size(), 3u) << "those of one robot came into the other's frame";
  ASSERT_FALSE(diff.revisions.empty());
  EXPECT_THAT(diff.revisions.front().matches,
              testing::ElementsAre(std::pair(sessions_[0], sessions_[1])));
  ASSERT_EQ(pipeline_->GetMapInfo().components.size(), 1u);

  const auto undone = pipeline_->decisions().UndoRevision(wrong, "not there");
  ASSERT_TRUE(undone.ok()) << undone.status();
  EXPECT_GT(*undone, wrong);
  EXPECT_EQ(pipeline_->GetMapInfo().components.size(), 2u);
  EXPECT_LT(LargestDifference(PathOf(kAlice), alice), 1e-3);
  EXPECT_LT(LargestDifference(PathOf(kBob), bob), 1e-3);
  EXPECT_EQ(CountVerdicts(*pipeline_), 0) << "what was given is withdrawn";
  EXPECT_TRUE(pipeline_->reader().DiffRevisions(before, 0)->moves.empty()) << "they came back";
  EXPECT_EQ(pipeline_->decisions().UndoRevision(wrong, "").status().code(),
            absl::StatusCode::kFailedPrecondition)
      << "nothing of it counts any more";
}

TEST_F(PipelineRevisions, AreListedNewestFirstAndRefusedWhereThereAreNone) {
  // All that came before may be one revision, or several.
  ASSERT_TRUE(Add(sessions_[0], 3).ok());
  pipeline_->WaitUntilIdle();
  const std::vector<RevisionInfo> newest = pipeline_->reader().ListRevisions(2).value();
  ASSERT_EQ(newest.size(), 2u);
  EXPECT_EQ(newest[0].revision, Revision());
  EXPECT_EQ(newest[1].revision, Revision() - 1);
  EXPECT_EQ(pipeline_->reader().DiffRevisions(Revision(), 1).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(pipeline_->reader().DiffRevisions(1, Revision() + 9).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(pipeline_->decisions().UndoRevision(Revision() + 9, "").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(pipeline_->decisions().UndoRevision(1, "").status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(PipelineRevisions, WhatChangedIsAskedByRevisionOrByTime) {
  const int64_t before = Revision();
  ASSERT_TRUE(Add(sessions_[0], 3).ok());
  pipeline_->WaitUntilIdle();
  const auto find = [&](const ChangeQuery& query) {
    return pipeline_->reader().FindChanges(query, [] { return true; });
  };
  const auto by_revision = find({.since_revision = before});
  ASSERT_TRUE(by_revision.ok()) << by_revision.status();
  EXPECT_EQ(by_revision->revision, Revision());
  EXPECT_EQ(by_revision->submaps_before, 3u);
  EXPECT_EQ(by_revision->submaps_after, 1u);
  EXPECT_TRUE(by_revision->volumes.empty()) << "nobody looked at what others saw";
  // The second was scanned from 2 s to 2.4 s: then it is of neither side.
  const auto by_time = find({.since_ns = 2'200'000'000});
  ASSERT_TRUE(by_time.ok()) << by_time.status();
  EXPECT_EQ(by_time->submaps_before, 1u);
  EXPECT_EQ(by_time->submaps_after, 2u);
}

TEST_F(PipelineRevisions, WhatChangedCannotBeToldWithoutBothSides) {
  const auto fails = [&](const ChangeQuery& query) {
    return pipeline_->reader().FindChanges(query, [] { return true; }).status();
  };
  const absl::Status latest = fails({.since_revision = Revision()});
  EXPECT_EQ(latest.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(latest.message()), HasSubstr("after that: it was scanned from 1970"));
  EXPECT_EQ(fails({.since_ns = 1}).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(fails({.since_revision = Revision() + 1}).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(fails({.since_ns = 2'200'000'000, .component = 9}).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(pipeline_->reader()
                .FindChanges({.since_ns = 2'200'000'000}, [] { return false; })
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

TEST_F(PipelineRevisions, ADeletedSessionLeavesWithoutTheOthersMoving) {
  const Trajectory bob = PathOf(kBob);
  const int64_t before = Revision();
  ASSERT_TRUE(pipeline_->sessions().Delete(sessions_[0]).ok());
  const RevisionDiff diff = pipeline_->reader().DiffRevisions(before, 0).value();
  ASSERT_EQ(diff.moves.size(), 3u);
  EXPECT_FALSE(diff.moves[0].after);
  EXPECT_LT(LargestDifference(PathOf(kBob), bob), 1e-9);
}

TEST_F(PipelineRevisions, AnAnchorPutsTheMapIntoItsFrame) {
  const Pose wanted = Pose::FromXyzRpy(100, 50, 3, 0, 0, 2);
  const SubmapId submap{sessions_[0], 1};
  Anchor anchor;
  anchor.submap = submap;
  anchor.T_map_submap = wanted;
  anchor.sigma_xy_m = anchor.sigma_z_m = 0.01;
  anchor.sigma_deg = 0.1;
  const Trajectory before = PathOf(kAlice);
  const auto revision = pipeline_->decisions().PutAnchor(anchor);
  ASSERT_TRUE(revision.ok()) << revision.status();
  EXPECT_EQ(*revision, Revision());
  const Trajectory anchored = PathOf(kAlice);
  EXPECT_LT((anchored[5].pose.translation() - wanted.translation()).norm(), 0.01);
  EXPECT_NEAR((anchored[14].pose.translation() - anchored[0].pose.translation()).norm(),
              (before[14].pose.translation() - before[0].pose.translation()).norm(), 0.01);
  EXPECT_EQ(pipeline_->reader().ListAnchors(*pipeline_->reader().View()).size(), 1u);

  ASSERT_TRUE(pipeline_->decisions().RemoveAnchor(submap).ok());
  EXPECT_LT(LargestDifference(PathOf(kAlice), before), 1e-3);
  EXPECT_EQ(pipeline_->decisions().RemoveAnchor(submap).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(PipelineRevisions, AnchorsThatMeanNothingAreRefused) {
  Anchor anchor;
  anchor.submap = {sessions_[0], 0};
  const auto code = [&] { return pipeline_->decisions().PutAnchor(anchor).status().code(); };
  EXPECT_EQ(code(), absl::StatusCode::kInvalidArgument) << "nothing is known";
  anchor.sigma_xy_m = 1;
  anchor.T_map_submap = Pose(Eigen::Vector3d(1e6, 0, 0));
  EXPECT_EQ(code(), absl::StatusCode::kInvalidArgument) << "too far out";
  anchor.T_map_submap = Pose();
  anchor.submap.index = 99;
  EXPECT_EQ(code(), absl::StatusCode::kNotFound);
}

TEST_F(PipelineRevisions, ThePoseGraphIsExported) {
  const auto g2o = pipeline_->ExportPoseGraph(0);
  ASSERT_TRUE(g2o.ok()) << g2o.status();
  EXPECT_THAT(*g2o, HasSubstr("VERTEX_SE3:QUAT"));
  EXPECT_THAT(*g2o, HasSubstr("alice-1/2"));
  EXPECT_EQ(pipeline_->ExportPoseGraph(7).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace isthmus::server
