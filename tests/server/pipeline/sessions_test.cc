#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

TEST(PipelineSessions, RefusesNamesAndSensorsItCannotUse) {
  auto pipeline = OpenInMemory();
  for (const char* name : {"", "two words", "../etc", "caf\xc3\xa9"}) {
    EXPECT_EQ(pipeline->sessions().Create({RobotId(name), "vlp16"}).status().code(),
              absl::StatusCode::kInvalidArgument)
        << name;
  }
  EXPECT_FALSE(pipeline->sessions().Create({RobotId(std::string(65, 'a')), "vlp16"}).ok());
  const absl::Status odd = pipeline->sessions().Create({RobotId("c\x1b[31m\n"), "vlp16"}).status();
  EXPECT_THAT(std::string(odd.message()), HasSubstr("robot name \"c\\x1b[31m\\x0a\" cannot"));
  const absl::Status sensor = pipeline->sessions().Create({kAlice, "sonar"}).status();
  EXPECT_EQ(sensor.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(sensor.message()), HasSubstr("vlp16"));
  EXPECT_TRUE(pipeline->sessions().List().empty());
}

TEST(PipelineSessions, ASensorIsStoredByTheNameOfItsModel) {
  auto pipeline = OpenInMemory();
  const auto session =
      pipeline->sessions().Create({kAlice, "Velodyne VLP-32C" + std::string(900, '-')});
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->record.sensor, "vlp32");
  EXPECT_EQ(pipeline->sessions().List().front().record.sensor, "vlp32");
}

TEST(PipelineSessions, ARobotsNewestSessionAnswers) {
  auto pipeline = OpenInMemory();
  const SessionId first = Create(*pipeline), second = Create(*pipeline);
  EXPECT_NE(first, second);
  EXPECT_EQ(pipeline->reader().GetTrajectory(kAlice, TrajectoryFrame::kOdom)->session, second);
}

TEST(PipelineSessions, NoSessionIsNamedLikeARobot) {
  auto pipeline = OpenInMemory();
  EXPECT_EQ(Create(*pipeline, RobotId("bob-1")), SessionId("bob-1-1"));
  EXPECT_EQ(Create(*pipeline, RobotId("bob")), SessionId("bob-2"));
}

// Stores may have such names already.
TEST(PipelineSessions, ASessionsIdGoesBeforeARobotsName) {
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline, kBob);
  const RobotId named(session.value());
  const SessionId other = Create(*pipeline, named);
  const MapReader& reader = pipeline->reader();
  EXPECT_EQ(reader.GetTrajectory(named, TrajectoryFrame::kOdom)->session, session);
  EXPECT_EQ(reader.GetTrajectory(kBob, TrajectoryFrame::kOdom)->session, session);
  EXPECT_EQ(reader.GetTrajectory(RobotId(other.value()), TrajectoryFrame::kOdom)->session, other);
  // Both names mean one session, so nothing has to connect them.
  EXPECT_TRUE(reader.GetTransform(named, kBob).ok());
  EXPECT_FALSE(reader.GetTransform(named, RobotId(other.value())).ok());
}

TEST(PipelineSessions, EveryScanIsAcknowledgedOnceInOrder) {
  Drive drive;
  AckLog log;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 11).ok());
  pipeline->WaitUntilIdle();  // The first submaps are placed.
  ASSERT_TRUE(drive.Submit(*pipeline, session, 11, 12).ok());
  pipeline->WaitUntilIdle();
  const std::vector<ScanAck> all = log.Take();
  std::vector<ScanAck> acks = all;
  std::erase_if(acks, [](const ScanAck& ack) { return ack.sequence == 0; });
  ASSERT_EQ(acks.size(), 12u);
  for (uint64_t i = 0; i < 12; ++i) {
    EXPECT_EQ(acks[i].sequence, i + 1);
    EXPECT_EQ(acks[i].outcome, ScanOutcome::kProcessed) << acks[i].reason;
    EXPECT_TRUE(acks[i].T_odom_sensor.has_value());
    EXPECT_LE(acks[i].durable_sequence, acks[i].sequence);
  }
  EXPECT_EQ(all.back().durable_sequence, 10u);  // Two submaps of five scans.
  EXPECT_TRUE(acks.back().T_map_odom.has_value());
}

TEST(PipelineSessions, DuplicatesAreHarmlessAndGapsAreRefused) {
  Drive drive;
  AckLog log;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  for (int index : {0, 1, 0, 1, 2}) {
    ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(index)).ok());
  }
  const absl::Status gap = pipeline->sessions().SubmitScan(session, drive.Upload(7));
  EXPECT_EQ(gap.code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(gap.message()), HasSubstr("4 is expected"));
  pipeline->WaitUntilIdle();
  const std::vector<ScanAck> acks = log.Take();
  ASSERT_EQ(acks.size(), 5u);
  EXPECT_EQ(acks[2].outcome, ScanOutcome::kDuplicate);
  EXPECT_EQ(acks[3].outcome, ScanOutcome::kDuplicate);
  EXPECT_EQ(acks[4].outcome, ScanOutcome::kProcessed);
  EXPECT_EQ(pipeline->reader().GetTrajectory(kAlice, TrajectoryFrame::kOdom)->poses.size(), 3u);
}

TEST(PipelineSessions, AScanThatCannotBeUsedIsRejectedAndTheSessionGoesOn) {
  Drive drive;
  AckLog log;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(0)).ok());
  ScanUpload empty = drive.Upload(1);
  empty.payload.data.clear();
  empty.payload.width = 0;
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, empty).ok());
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(2)).ok());
  pipeline->WaitUntilIdle();
  const std::vector<ScanAck> acks = log.Take();
  ASSERT_EQ(acks.size(), 3u);
  EXPECT_EQ(acks[1].outcome, ScanOutcome::kRejected);
  EXPECT_FALSE(acks[1].reason.empty());
  EXPECT_EQ(acks[2].outcome, ScanOutcome::kProcessed);
  EXPECT_EQ(pipeline->sessions().Get(session)->scans_rejected, 1u);
}

TEST(PipelineSessions, FinishingMakesEverythingDurableAndClosesTheSession) {
  Drive drive;
  AckLog log;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 7).ok());
  const SessionStatus status = pipeline->sessions().Finish(session).value();
  EXPECT_EQ(status.record.state, SessionState::kFinished);
  EXPECT_EQ(status.durable_sequence, 7u);
  EXPECT_EQ(status.submap_count, 2u);
  EXPECT_EQ(log.Take().back().durable_sequence, 7u);
  EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
  EXPECT_EQ(pipeline->sessions().SubmitScan(session, drive.Upload(7)).code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(pipeline->sessions().Finish(SessionId("nobody-1")).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(PipelineSessions, ADeletedSessionLeavesTheMap) {
  Drive drive;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 5).ok());
  pipeline->WaitUntilIdle();
  EXPECT_GT(pipeline->reader().Map()->point_count(0), 1000u);
  const int64_t revision = pipeline->GetMapInfo().revision;
  ASSERT_TRUE(pipeline->sessions().Delete(session).ok());
  pipeline->WaitUntilIdle();
  EXPECT_EQ(pipeline->reader().Map()->point_count(0), 0u);
  EXPECT_GT(pipeline->GetMapInfo().revision, revision);
  EXPECT_EQ(pipeline->sessions().Delete(session).code(), absl::StatusCode::kNotFound);
}

TEST(PipelineSessions, AFullDiskStopsThatRobotAndNothingIsLost) {
  Drive drive;
  auto full = std::make_shared<std::atomic<bool>>(false);
  auto pipeline =
      Pipeline::Open(QuickOptions(), std::make_unique<FullDisk>(storage::MakeMemoryStore(), full))
          .value();
  const SessionId session = Create(*pipeline);
  *full = true;
  absl::Status status;
  int sent = 0;
  while (sent < 40 && status.ok()) {
    status = pipeline->sessions().SubmitScan(session, drive.Upload(sent));
    if (status.ok()) ++sent;
    pipeline->WaitUntilIdle();
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("disk full"));
  EXPECT_EQ(sent, 10);  // Two submaps wait for the disk; a third would have no end.
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 0u);
  *full = false;
  ASSERT_TRUE(pipeline->sessions().SubmitScan(session, drive.Upload(sent)).ok());
  EXPECT_EQ(pipeline->sessions().Finish(session)->durable_sequence, 11u);
  EXPECT_EQ(pipeline->reader().ListSubmaps(kAlice)->size(), 3u);
}

TEST(PipelineSessions, AfterShutdownRobotsAreToldToTryAgain) {
  Drive drive;
  auto pipeline = OpenInMemory();
  const SessionId session = Create(*pipeline);
  ASSERT_TRUE(drive.Submit(*pipeline, session, 0, 3).ok());
  pipeline->Shutdown();
  EXPECT_EQ(pipeline->sessions().SubmitScan(session, drive.Upload(3)).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(pipeline->sessions().Get(session)->durable_sequence, 3u);
}

}  // namespace
}  // namespace isthmus::server
