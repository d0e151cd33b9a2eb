// Whole drives through the whole server but its network: drives that end up in one frame, and
// drives that never must.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

// Streams scans of the first robot under a name.
void DrivePart(const simulation::Simulator& simulator, const RobotId& name, int begin, int end,
               Pipeline& pipeline) {
  const SessionId session = Create(pipeline, name);
  for (int i = begin; i < end; ++i) {
    const Scan scan = simulator.MakeScan(0, i);
    const auto sequence = static_cast<uint64_t>(i - begin) + 1;
    ASSERT_TRUE(pipeline.sessions()
                    .SubmitScan(session, {sequence, scan.end_stamp_ns, codec::MakePayload(scan)})
                    .ok());
  }
  ASSERT_TRUE(pipeline.sessions().Finish(session).ok());
  pipeline.WaitUntilIdle();
}

// Streams every scan of every robot and finishes the sessions; robot i is called "robot_i".
void DriveAll(const simulation::Simulator& simulator, Pipeline& pipeline) {
  for (int robot = 0; robot < simulator.robots(); ++robot) {
    const RobotId name("robot_" + std::to_string(robot));
    const SessionId session = pipeline.sessions().Create({name, "vlp16"}).value().record.id;
    for (int i = 0; i < simulator.scan_count(); ++i) {
      const Scan scan = simulator.MakeScan(robot, i);
      ASSERT_TRUE(
          pipeline.sessions()
              .SubmitScan(session, {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)})
              .ok());
    }
    ASSERT_TRUE(pipeline.sessions().Finish(session).ok());
  }
  pipeline.WaitUntilIdle();
}

std::unique_ptr<simulation::Simulator> Simulate(const std::string& world, double seconds,
                                                uint64_t seed) {
  simulation::Options options;
  options.world = world;
  options.seconds = seconds;
  options.seed = seed;
  return std::move(simulation::Simulator::Create(options).value());
}

TEST(PipelineMerge, TwoRobotsOfAMuseumEndUpInOneFrame) {
  const auto simulator = Simulate("museum", 60, 4);
  auto pipeline = OpenInMemory({});
  DriveAll(*simulator, *pipeline);
  ASSERT_EQ(pipeline->GetMapInfo().components.size(), 1u);

  const Pose T_0_1 =
      pipeline->reader().GetTransform(RobotId("robot_0"), RobotId("robot_1")).value().T_a_b;
  const Pose truth = simulator->Truth(0, 0).pose.Inverse() * simulator->Truth(1, 0).pose;
  const Pose error = truth.Inverse() * T_0_1;
  EXPECT_LT(error.translation().norm(), 0.1);
  EXPECT_LT(RotationAngle(error), 0.5 * M_PI / 180);

  // Both trajectories against the truth in the map frame, the odom frame of one of the robots.
  const SessionId reference = pipeline->GetMapInfo().components[0].reference;
  const int base = reference == SessionId("robot_0-1") ? 0 : 1;
  const Pose T_map_world = simulator->Truth(base, 0).pose.Inverse();
  for (int robot = 0; robot < 2; ++robot) {
    const RobotTrajectory trajectory =
        pipeline->reader()
            .GetTrajectory(RobotId("robot_" + std::to_string(robot)), TrajectoryFrame::kMap)
            .value();
    ASSERT_EQ(trajectory.poses.size(), 600u);
    double sum = 0;
    for (int i = 0; i < 600; ++i) {
      const Pose expected = T_map_world * simulator->Truth(robot, i).pose;
      sum += (trajectory.poses[i].pose.translation() - expected.translation()).squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / 600), 0.15) << "robot " << robot;
  }
}

// The site has places built alike.
PipelineOptions WithTwins() {
  PipelineOptions options;
  options.matcher.twins = matching::Twins::kExact;
  return options;
}

// Two closed rooms, built alike: whatever fits, nothing connects them.
TEST(PipelineMerge, RobotsInTwinRoomsStayApart) {
  const auto simulator = Simulate("twins", 30, 4);
  auto pipeline = OpenInMemory(WithTwins());
  DriveAll(*simulator, *pipeline);
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 2u);
  ASSERT_EQ(pipeline->reader().GetMatchGraph().matches.size(), 1u);
  EXPECT_NE(pipeline->reader().GetMatchGraph().matches[0].match.state, MatchState::kAccepted);
  EXPECT_EQ(pipeline->reader().GetTransform(RobotId("robot_0"), RobotId("robot_1")).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

// The rooms were taken for one when little of them had been seen.
TEST(PipelineMerge, WhatMoreSubmapsDoNotBearOutIsGivenUp) {
  const auto simulator = Simulate("twins", 30, 4);
  storage::WriteBatch batch;
  {
    auto memory = storage::MakeMemoryStore();
    const storage::MapStore* store = memory.get();
    const auto pipeline = Pipeline::Open(WithTwins(), std::move(memory)).value();
    DriveAll(*simulator, *pipeline);
    Match match = pipeline->reader().GetMatchGraph().matches.at(0).match;
    ASSERT_GT(std::max(match.submaps_a, match.submaps_b), 1u) << "nothing comes later";
    match.state = MatchState::kAccepted;
    match.reason = MatchReason::kOk;
    match.confidence = 0.98;
    match.submaps_a = match.submaps_b = 1;
    batch.matches.push_back(match);
    for (const SessionId& session : {match.a, match.b}) {
      batch.sessions.push_back(store->GetSession(session).value());
      for (uint32_t i = 0; store->GetSubmap({session, i}).ok(); ++i) {
        batch.submaps.push_back(store->GetSubmap({session, i}).value());
      }
    }
  }
  auto memory = storage::MakeMemoryStore();
  ASSERT_TRUE(memory->Write(batch).ok());
  const auto pipeline = Pipeline::Open(WithTwins(), std::move(memory)).value();
  pipeline->WaitUntilIdle();
  const Match match = pipeline->reader().GetMatchGraph().matches.at(0).match;
  EXPECT_NE(match.state, MatchState::kAccepted) << match.detail;
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 2u);
}

// Two drives through one of the twin rooms: it may be the other, unless it is known where they
// began.
TEST(PipelineMerge, AnchorsTellWhichOfTwoRoomsItIs) {
  const auto simulator = Simulate("twins_large", 60, 4);
  auto pipeline = OpenInMemory(WithTwins());
  DrivePart(*simulator, kAlice, 0, 350, *pipeline);
  DrivePart(*simulator, kBob, 250, 600, *pipeline);
  const auto match = [&] { return pipeline->reader().GetMatchGraph().matches.at(0).match; };
  EXPECT_EQ(match().reason, MatchReason::kPossibleTwin) << match().detail;

  const auto put_anchor = [&](const RobotId& robot, int scan) {
    Anchor anchor;
    anchor.submap = {SessionId(robot.value() + "-1"), 0};
    anchor.T_map_submap = simulator->Truth(0, scan).pose;
    anchor.sigma_xy_m = 1;
    anchor.sigma_z_m = 0.5;
    anchor.sigma_deg = 5;
    ASSERT_TRUE(pipeline->decisions().PutAnchor(anchor).ok());
    pipeline->WaitUntilIdle();
  };
  put_anchor(kAlice, 0);
  EXPECT_EQ(match().reason, MatchReason::kPossibleTwin) << "one alone says nothing of the other";
  put_anchor(kBob, 250);
  EXPECT_EQ(match().state, MatchState::kAccepted) << match().detail;
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 1u);

  ASSERT_TRUE(pipeline->decisions().RemoveAnchor({SessionId("bob-1"), 0}).ok());
  pipeline->WaitUntilIdle();
  EXPECT_EQ(match().reason, MatchReason::kPossibleTwin) << "what it rested on is gone";
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 2u);
}

}  // namespace
}  // namespace isthmus::server
