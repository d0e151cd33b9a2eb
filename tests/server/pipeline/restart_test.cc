#include <gtest/gtest.h>

#include <filesystem>

#include "storage/sqlite_store.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

class PipelineRestart : public testing::Test {
 protected:
  PipelineRestart()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~PipelineRestart() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<Pipeline> Open() {
    return Pipeline::Open(QuickOptions(), storage::OpenSqliteStore(folder_.string()).value())
        .value();
  }

  const std::filesystem::path folder_;
};

TEST_F(PipelineRestart, SessionsMapAndTrajectoriesAreThereAgain) {
  Drive drive;
  SessionId session;
  RobotTrajectory before;
  uint64_t points = 0;
  {
    auto pipeline = Open();
    session = pipeline->CreateSession({RobotId("alice"), "vlp16"}).value().record.id;
    for (int i = 0; i < 8; ++i) ASSERT_TRUE(pipeline->SubmitScan(session, drive.Upload(i)).ok());
    ASSERT_TRUE(pipeline->FinishSession(session).ok());
    pipeline->WaitUntilIdle();
    before = pipeline->GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap).value();
    points = pipeline->GetMap()->point_count(0);
  }
  auto pipeline = Open();
  pipeline->WaitUntilIdle();
  const RobotTrajectory after =
      pipeline->GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap).value();
  ASSERT_EQ(after.poses.size(), 8u);
  EXPECT_EQ(after.revision, before.revision);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_LT((after.poses[i].pose.translation() - before.poses[i].pose.translation()).norm(),
              1e-9);
  }
  // The store rounds to a millimetre, so a few points change voxel.
  EXPECT_NEAR(double(pipeline->GetMap()->point_count(0)), double(points), 0.02 * double(points));
  EXPECT_EQ(pipeline->GetSession(session)->record.state, SessionState::kFinished);
}

TEST_F(PipelineRestart, AnActiveSessionGoesOnInTheSameOdomFrame) {
  Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->CreateSession({RobotId("alice"), "vlp16"}).value().record.id;
    for (int i = 0; i < 42; ++i) ASSERT_TRUE(pipeline->SubmitScan(session, drive.Upload(i)).ok());
    pipeline->Shutdown();
  }
  AckLog log;
  auto pipeline = Open();
  EXPECT_EQ(pipeline->GetSession(session)->durable_sequence, 42u);
  ASSERT_TRUE(pipeline->SetAckSink(session, log.Sink()).ok());
  for (int i = 40; i < 60; ++i) ASSERT_TRUE(pipeline->SubmitScan(session, drive.Upload(i)).ok());
  pipeline->WaitUntilIdle();
  const std::vector<ScanAck> acks = log.Take();
  ASSERT_EQ(acks.size(), 20u);
  EXPECT_EQ(acks[1].outcome, ScanOutcome::kDuplicate);
  EXPECT_EQ(acks[2].outcome, ScanOutcome::kProcessed);
  const Pose T_sensor_odom = drive.simulator().Truth(0, 0).pose.Inverse();
  for (int i = 42; i < 60; ++i) {
    const ScanAck& ack = acks[i - 40];
    EXPECT_EQ(ack.status, "ok");
    const Pose truth = T_sensor_odom * drive.simulator().Truth(0, i).pose;
    EXPECT_LT((ack.T_odom_sensor->translation() - truth.translation()).norm(), 0.1) << i;
  }
  EXPECT_EQ(pipeline->GetTrajectory(RobotId("alice"), TrajectoryFrame::kOdom)->poses.size(), 60u);
}

}  // namespace
}  // namespace isthmus::server
