#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

// A wall of points, seen from two places.
Submap Wall(const SessionId& session, uint32_t index) {
  Submap submap;
  submap.id = {session, index};
  submap.T_odom_submap = Pose(Eigen::Vector3d(5.0 * index, 0, 0));
  submap.keyframes = {{0, 1'000, Pose()}, {0, 2'000, Pose(Eigen::Vector3d(1, 0, 0))}};
  for (int i = 0; i < 400; ++i) {
    const int column = i % 20, row = i / 20;
    submap.points.push_back({3.f, 0.2f * column, 0.2f * row, 1.f, uint16_t(i % 2)});
  }
  return submap;
}

class PipelineUploads : public testing::Test {
 protected:
  std::unique_ptr<Pipeline> pipeline_ = OpenInMemory();
  Sessions& sessions_ = pipeline_->sessions();
  const SessionId session_ = sessions_.Create({RobotId("bob"), "vlp16"}).value().record.id;
};

TEST_F(PipelineUploads, AnUploadedSubmapAppearsInTheMap) {
  const SubmapInfo info = sessions_.AddSubmap(Wall(session_, 0)).value();
  EXPECT_EQ(info.point_count, 400u);
  EXPECT_EQ(info.robot, RobotId("bob"));
  pipeline_->WaitUntilIdle();
  EXPECT_GT(pipeline_->reader().Map()->point_count(0), 0u);
  const RobotTrajectory trajectory =
      pipeline_->reader().GetTrajectory(RobotId("bob"), TrajectoryFrame::kMap).value();
  ASSERT_EQ(trajectory.poses.size(), 2u);
  EXPECT_EQ(trajectory.poses[1].pose.translation(), Eigen::Vector3d(1, 0, 0));
}

TEST_F(PipelineUploads, RepeatingHasNoEffectAndOtherContentIsRefused) {
  ASSERT_TRUE(sessions_.AddSubmap(Wall(session_, 0)).ok());
  EXPECT_TRUE(sessions_.AddSubmap(Wall(session_, 0)).ok());
  EXPECT_EQ(pipeline_->reader().ListSubmaps(std::nullopt)->size(), 1u);
  Submap other = Wall(session_, 0);
  other.points[7].x += 1;
  EXPECT_EQ(sessions_.AddSubmap(other).status().code(), absl::StatusCode::kAlreadyExists);
}

TEST_F(PipelineUploads, KeyframesAreNotCountedAsScans) {
  const std::string folder = testing::TempDir() + "uploads_keyframes";
  std::filesystem::remove_all(folder);
  SessionId session;
  for (const bool again : {false, true}) {
    const std::unique_ptr<Pipeline> pipeline =
        Pipeline::Open(QuickOptions(), storage::OpenSqliteStore(folder).value()).value();
    if (!again) {
      session = pipeline->sessions().Create({RobotId("bob"), "vlp16"}).value().record.id;
      for (const uint32_t index : {0, 1}) {
        ASSERT_TRUE(pipeline->sessions().AddSubmap(Wall(session, index)).ok());
      }
      ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
    }
    EXPECT_EQ(pipeline->sessions().Get(session)->last_sequence, 0u) << again;
    EXPECT_EQ(pipeline->sessions().Get(session)->submap_count, 2u);
  }
}

TEST_F(PipelineUploads, TheNextIndexIsNamedWhereOneIsLeftOut) {
  const absl::Status gap = sessions_.AddSubmap(Wall(session_, 3)).status();
  EXPECT_EQ(gap.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(gap.message()), HasSubstr("0 is expected"));
}

TEST_F(PipelineUploads, RefusesWhatCannotBeAMap) {
  Submap empty = Wall(session_, 0);
  empty.points.clear();
  Submap infinite = Wall(session_, 0);
  infinite.points[3].z = std::numeric_limits<float>::infinity();
  Submap unseen = Wall(session_, 0);
  unseen.points[3].keyframe = 2;
  Submap homeless = Wall(session_, 0);
  homeless.keyframes.clear();
  for (const Submap& bad : {empty, infinite, unseen, homeless}) {
    EXPECT_EQ(sessions_.AddSubmap(bad).status().code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_EQ(sessions_.AddSubmap(Wall(SessionId("nobody-1"), 0)).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_TRUE(sessions_.AddSubmap(Wall(session_, 0)).ok());
}

TEST_F(PipelineUploads, ScansAndUploadsDoNotMix) {
  Drive drive;
  ASSERT_TRUE(sessions_.AddSubmap(Wall(session_, 0)).ok());
  EXPECT_EQ(sessions_.SubmitScan(session_, drive.Upload(0)).code(),
            absl::StatusCode::kFailedPrecondition);
  const SessionId scans = sessions_.Create({RobotId("bob"), "vlp16"}).value().record.id;
  ASSERT_TRUE(sessions_.SubmitScan(scans, drive.Upload(0)).ok());
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(sessions_.AddSubmap(Wall(scans, 0)).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(PipelineUploads, RobotsWithoutACommonWallStayApart) {
  const SessionId other = sessions_.Create({RobotId("carol"), "vlp16"}).value().record.id;
  ASSERT_TRUE(sessions_.AddSubmap(Wall(session_, 0)).ok());
  ASSERT_TRUE(sessions_.AddSubmap(Wall(other, 0)).ok());
  pipeline_->WaitUntilIdle();
  EXPECT_EQ(pipeline_->GetMapInfo().components.size(), 2u);
  const absl::Status transform =
      pipeline_->reader().GetTransform(RobotId("bob"), RobotId("carol")).status();
  EXPECT_EQ(transform.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(pipeline_->reader().GetTransform(RobotId("bob"), RobotId("dave")).status().code(),
            absl::StatusCode::kNotFound);
  ASSERT_EQ(pipeline_->reader().GetMatchGraph().matches.size(), 1u);
  EXPECT_NE(pipeline_->reader().GetMatchGraph().matches[0].match.state, MatchState::kAccepted);
}

}  // namespace
}  // namespace isthmus::server
