// Sessions of several segments as people and robots ask for them: kept apart until a match joins
// them, and one thing where they are finished, deleted and counted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/pipeline/robots.h"
#include "tests/storage/records.h"

namespace isthmus::server {
namespace {

using absl::StatusCode;
using storage::MakeSession;
using storage::MakeSubmap;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const SessionId kFirst("alice-1"), kSecond("alice-1.2"), kBobs("bob-1");
const Pose kFirstSecond = Pose::FromXyzRpy(100, -20, 1, 0, 0, 0.5);

// A session of two segments, two submaps of ten scans each, and another robot's of one.
class StoredSegments : public ::testing::Test {
 protected:
  storage::WriteBatch Contents() const {
    storage::WriteBatch batch;
    SessionRecord second = MakeSession(kSecond.value());
    second.segment = 2;
    second.first_segment = kFirst;
    batch.sessions = {MakeSession(kFirst.value()), MakeSession(kBobs.value(), "bob"), second};
    for (const SessionId& session : {kFirst, kSecond}) {
      const uint64_t before = session == kFirst ? 0 : 30;  // Ten scans between them were lost.
      for (uint32_t index = 0; index < 2; ++index) {
        const auto submap = MakeSubmap(session.value(), index);
        submap->first_sequence = before + 10 * index + 1;
        submap->last_sequence = before + 10 * index + 10;
        for (uint64_t k = submap->first_sequence; k <= submap->last_sequence; ++k) {
          TrajectoryEntry entry = storage::MakeEntry(k);
          entry.T_odom_sensor = submap->T_odom_submap;
          entry.submap_index = index;
          batch.trajectory.emplace_back(session, entry);
        }
        batch.submaps.push_back(submap);
      }
    }
    batch.submaps.push_back(MakeSubmap(kBobs.value(), 0));
    return batch;
  }

  // Finished, unless the batch is changed.
  void Open(const std::function<void(storage::WriteBatch&)>& change = [](auto&) {}) {
    auto store = storage::MakeMemoryStore();
    storage::WriteBatch batch = Contents();
    for (SessionRecord& record : batch.sessions) {
      record.state = SessionState::kFinished;
      record.finished_ns = record.created_ns + 1;
    }
    change(batch);
    ASSERT_TRUE(store->Write(batch).ok());
    pipeline_ = Pipeline::Open(QuickOptions(), std::move(store)).value();
    pipeline_->WaitUntilIdle();
  }

  void Join() {
    MatchDecision decision;
    decision.session_a = kFirst;
    decision.session_b = kSecond;
    decision.kind = ManualDecisionKind::kSet;
    decision.T_a_b = kFirstSecond;
    ASSERT_TRUE(pipeline_->decisions().DecideMatch(decision).ok());
  }

  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(StoredSegments, AreAskedForOneByOneInOdom) {
  Open();
  const RobotTrajectory last =
      pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kOdom).value();
  EXPECT_EQ(last.session, kFirst);
  ASSERT_EQ(last.parts.size(), 1u);
  EXPECT_EQ(last.parts[0].segment, 2u);
  EXPECT_EQ(last.poses.size(), 20u);
  EXPECT_EQ(last.poses.front().stamp_ns, storage::MakeEntry(31).stamp_ns);
  EXPECT_THAT(last.left_out, ElementsAre(1));
  const RobotTrajectory first =
      pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kOdom, 1).value();
  EXPECT_EQ(first.poses.front().stamp_ns, storage::MakeEntry(1).stamp_ns);
  EXPECT_THAT(first.left_out, ElementsAre(2));
  for (const TrajectoryFrame frame : {TrajectoryFrame::kOdom, TrajectoryFrame::kMap}) {
    const absl::Status unknown = pipeline_->reader().GetTrajectory(kAlice, frame, 3).status();
    EXPECT_EQ(unknown.code(), StatusCode::kNotFound);
    EXPECT_THAT(std::string(unknown.message()), HasSubstr("no segment 3"));
  }
}

TEST_F(StoredSegments, AreApartInTheMapUntilAMatchJoinsThem) {
  Open();
  const RobotTrajectory apart =
      pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kMap).value();
  EXPECT_EQ(apart.parts.size(), 1u) << "two frames in one answer";
  EXPECT_EQ(apart.left_out.size(), 1u);
  EXPECT_EQ(apart.poses.size(), 20u);
  EXPECT_NE(pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kMap, 1)->component,
            pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kMap, 2)->component);
  Join();
  const RobotTrajectory joined =
      pipeline_->reader().GetTrajectory(kAlice, TrajectoryFrame::kMap).value();
  ASSERT_EQ(joined.parts.size(), 2u);
  EXPECT_TRUE(joined.left_out.empty());
  ASSERT_EQ(joined.poses.size(), 40u);
  for (size_t k = 1; k < joined.poses.size(); ++k) {
    EXPECT_GT(joined.poses[k].stamp_ns, joined.poses[k - 1].stamp_ns);
  }
  const Pose between = joined.poses[0].pose.Inverse() * joined.poses[20].pose;
  const Pose odom = MakeSubmap("x", 0)->T_odom_submap;
  const Pose expected = odom.Inverse() * kFirstSecond * odom;
  EXPECT_LT((between.translation() - expected.translation()).norm(), 0.01);
}

TEST_F(StoredSegments, TheLastIsMeantWhereOnlyTheRobotIsNamed) {
  Open();
  MatchDecision decision;
  decision.robot_a = kAlice;
  decision.robot_b = kBob;
  decision.kind = ManualDecisionKind::kSet;
  const Match match = pipeline_->decisions().DecideMatch(decision).value().edge.match;
  EXPECT_EQ(match.a, kSecond);
  EXPECT_EQ(match.b, kBobs);
  EXPECT_TRUE(pipeline_->reader().GetTransform(kAlice, kBob).ok());
}

TEST_F(StoredSegments, AreListedAfterTheirSessionAndCountedWithIt) {
  Open();
  const std::vector<SessionStatus> list = pipeline_->sessions().List();
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].record.id, kFirst);
  EXPECT_EQ(list[1].record.id, kSecond);
  EXPECT_EQ(list[0].segments, 2u);
  EXPECT_EQ(list[0].last_sequence, 50u);
  EXPECT_EQ(list[1].record.segment, 2u);
  EXPECT_EQ(list[1].record.first_segment, kFirst);
  EXPECT_EQ(list[1].submap_count, 2u);
  EXPECT_EQ(list[1].map_bytes, 0u);
  EXPECT_GT(list[0].map_bytes, 3 * list[2].map_bytes) << "four submaps against one";
  std::vector<SessionId> placed;
  for (const PlacedSession& session : pipeline_->reader().GetMatchGraph().placements) {
    placed.push_back(session.placement.session);
  }
  EXPECT_THAT(placed, ElementsAre(kFirst, kSecond, kBobs));
}

TEST_F(StoredSegments, AreFinishedAndDeletedAsOne) {
  Open([](storage::WriteBatch& batch) {
    for (SessionRecord& record : batch.sessions) record.state = SessionState::kActive;
  });
  for (const absl::Status& status :
       {pipeline_->sessions().Finish(kSecond).status(), pipeline_->sessions().Delete(kSecond),
        pipeline_->sessions().SubmitScan(kSecond, {1, 1, {}}),
        pipeline_->sessions().SetAckSink(kSecond, [](auto&) {}),
        pipeline_->sessions().AddSubmap(*MakeSubmap(kSecond.value(), 2)).status()}) {
    EXPECT_EQ(status.code(), StatusCode::kFailedPrecondition) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("alice-1.2 is segment 2 of"));
  }
  ASSERT_TRUE(pipeline_->sessions().Finish(kFirst).ok());
  EXPECT_EQ(pipeline_->sessions().Get(kSecond)->record.state, SessionState::kFinished);
  EXPECT_GT(pipeline_->sessions().Get(kSecond)->record.finished_ns, 0);
  EXPECT_EQ(pipeline_->sessions().Get(kBobs)->record.state, SessionState::kActive);
  ASSERT_TRUE(pipeline_->sessions().Delete(kFirst).ok());
  EXPECT_EQ(pipeline_->sessions().Get(kSecond).status().code(), StatusCode::kNotFound);
  pipeline_->WaitUntilIdle();
  ASSERT_EQ(pipeline_->sessions().List().size(), 1u);
  EXPECT_EQ(pipeline_->GetMapInfo().submaps, 1u);
}

TEST_F(StoredSegments, GoWithTheirSessionWhenItIsTooOld) {
  auto store = storage::MakeMemoryStore();
  storage::WriteBatch batch = Contents();
  for (SessionRecord& record : batch.sessions) {
    record.state = SessionState::kFinished;
    record.finished_ns = record.created_ns;
  }
  ASSERT_TRUE(store->Write(batch).ok());
  PipelineOptions options = QuickOptions();
  options.retention.robots[kAlice].max_age_days = 1;
  const auto pipeline = Pipeline::Open(options, std::move(store)).value();
  pipeline->WaitUntilIdle();
  ASSERT_EQ(pipeline->sessions().List().size(), 1u);
  EXPECT_EQ(pipeline->sessions().List()[0].record.id, kBobs);
}

}  // namespace
}  // namespace isthmus::server
