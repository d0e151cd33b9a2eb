// A server whose memory holds next to nothing, and one with damage in its map.
#include <gtest/gtest.h>

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::server {
namespace {

class PipelineWorkingSet : public testing::Test {
 protected:
  PipelineWorkingSet()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~PipelineWorkingSet() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<Pipeline> Open(PipelineOptions options = QuickOptions()) {
    options.on_problem = [this](const std::string& problem) {
      std::lock_guard lock(mutex_);
      problems_.push_back(problem);
    };
    return Pipeline::Open(options, storage::MakeFaultyStore(
                                       storage::OpenSqliteStore(folder_.string()).value(), faults_))
        .value();
  }

  // Two robots on the same way, so that there is something to match; nine submaps.
  void DriveIn(Pipeline* pipeline) {
    Drive drive(2);
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session = pipeline->sessions()
                                    .Create({RobotId(robot == 0 ? "alice" : "bob"), "vlp16"})
                                    .value()
                                    .record.id;
      ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 20, robot).ok());
      ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
    }
    pipeline->WaitUntilIdle();
  }

  static std::vector<MapPoint> Points(Pipeline* pipeline, uint32_t component) {
    std::vector<MapPoint> points;
    Region region;
    region.component = component;
    EXPECT_TRUE(pipeline->reader()
                    .Map()
                    ->Read(region, 1000,
                           [&](const std::vector<MapPoint>& chunk) {
                             points.insert(points.end(), chunk.begin(), chunk.end());
                             return true;
                           })
                    .ok());
    return points;
  }

  std::vector<std::string> Problems() {
    std::lock_guard lock(mutex_);
    return problems_;
  }

  const std::filesystem::path folder_;
  const std::shared_ptr<storage::Faults> faults_ = std::make_shared<storage::Faults>();
  std::mutex mutex_;
  std::vector<std::string> problems_;
};

TEST_F(PipelineWorkingSet, TheMapDoesNotDependOnWhatStaysInMemory) {
  {
    auto pipeline = Open();
    DriveIn(pipeline.get());
  }
  std::vector<std::vector<MapPoint>> roomy, tight;
  {
    auto pipeline = Open();
    pipeline->WaitUntilIdle();
    for (uint32_t c = 0; c < pipeline->reader().Map()->component_count(); ++c) {
      roomy.push_back(Points(pipeline.get(), c));
    }
  }
  PipelineOptions options = QuickOptions();
  options.submap_cache_bytes = 1;
  options.prepared_bytes = 1;
  auto pipeline = Open(options);
  pipeline->WaitUntilIdle();
  for (uint32_t c = 0; c < pipeline->reader().Map()->component_count(); ++c) {
    tight.push_back(Points(pipeline.get(), c));
  }
  ASSERT_FALSE(roomy.empty());
  ASSERT_EQ(roomy.size(), tight.size());
  for (size_t c = 0; c < roomy.size(); ++c) {
    ASSERT_EQ(roomy[c].size(), tight[c].size());
    for (size_t i = 0; i < roomy[c].size(); ++i) {
      ASSERT_EQ(roomy[c][i].x, tight[c][i].x);
      ASSERT_EQ(roomy[c][i].y, tight[c][i].y);
      ASSERT_EQ(roomy[c][i].z, tight[c][i].z);
    }
  }
}

TEST_F(PipelineWorkingSet, ADamagedSubmapIsSetAsideAndTheRestIsServed) {
  RobotTrajectory before;
  {
    auto pipeline = Open();
    DriveIn(pipeline.get());
    before = pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kOdom).value();
  }
  faults_->Damage({SessionId("alice-1"), 1});
  auto pipeline = Open();
  pipeline->WaitUntilIdle();
  const MapInfo info = pipeline->GetMapInfo();
  ASSERT_EQ(info.damaged.size(), 1u);
  EXPECT_NE(info.damaged[0].find("alice-1/1"), std::string::npos) << info.damaged[0];
  EXPECT_EQ(Problems(), info.damaged);
  // It is known and placed as before; only its points are missing.
  EXPECT_EQ(pipeline->reader().ListSubmaps(RobotId("alice"))->size(), 4u);
  const RobotTrajectory after =
      pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kOdom).value();
  EXPECT_EQ(after.poses.size(), before.poses.size());
  uint64_t points = 0;
  for (const Component& component : info.components) points += component.point_count;
  EXPECT_GT(points, 0u);
}

TEST_F(PipelineWorkingSet, ASessionGoesOnBehindADamagedSubmap) {
  Drive drive;
  SessionId session;
  {
    auto pipeline = Open();
    session = pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
    ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 15).ok());
    pipeline->Shutdown();
  }
  faults_->Damage({session, 2});
  auto pipeline = Open();
  const SessionStatus resumed = pipeline->sessions().Get(session).value();
  EXPECT_EQ(resumed.durable_sequence, 15u);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 15, 25).ok());
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  pipeline->WaitUntilIdle();
  const auto submaps = pipeline->reader().ListSubmaps(RobotId("alice")).value();
  ASSERT_EQ(submaps.size(), 5u);
  for (uint32_t i = 0; i < 5; ++i) EXPECT_EQ(submaps[i].info.id.index, i);
  EXPECT_EQ(
      pipeline->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kOdom)->poses.size(),
      25u);
}

}  // namespace
}  // namespace isthmus::server
