// A person's decision on matches: it holds whatever is computed, over restarts, and can be taken
// back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "storage/sqlite/sqlite_store.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

const Pose kGiven = Pose::FromXyzRpy(12, -3, 0.5, 0, 0, 1.2);

bool Near(const Pose& a, const Pose& b) {
  const Pose difference = a.Inverse() * b;
  return difference.translation().norm() < 1e-9 && RotationAngle(difference) < 1e-9;
}

// Two robots that have seen one bare wall each: too little for any match.
void AddWalls(Pipeline& pipeline) {
  for (const RobotId& robot : {kAlice, kBob}) {
    Submap submap;
    submap.id = {pipeline.sessions().Create({robot, "vlp16"}).value().record.id, 0};
    submap.keyframes = {{0, 1'000, Pose()}, {0, 2'000, Pose(Eigen::Vector3d(1, 0, 0))}};
    for (int i = 0; i < 400; ++i) {
      submap.points.push_back({3.f, 0.2f * (i % 20), 0.2f * (i / 20), 1.f, uint16_t(i % 2)});
    }
    ASSERT_TRUE(pipeline.sessions().AddSubmap(submap).ok());
  }
  pipeline.WaitUntilIdle();
  ASSERT_EQ(pipeline.GetMapInfo().components.size(), 2u);
}

TEST(PipelineManualDecisions, ATransformGivenByHandJoinsTheMapsAndCanBeTakenBack) {
  const auto pipeline = OpenInMemory();
  AddWalls(*pipeline);
  const Match before = pipeline->reader().GetMatchGraph().matches.at(0).match;
  const RobotTrajectory bob = pipeline->reader().GetTrajectory(kBob, TrajectoryFrame::kMap).value();

  const auto match = pipeline->decisions().DecideMatch({.robot_a = kAlice,
                                                        .robot_b = kBob,
                                                        .kind = ManualDecisionKind::kSet,
                                                        .T_a_b = kGiven,
                                                        .note = "tape"});
  ASSERT_TRUE(match.ok()) << match.status();
  EXPECT_EQ(match->revision, pipeline->GetMapInfo().revision);
  EXPECT_EQ(match->edge.match.state, MatchState::kAccepted);
  EXPECT_THAT(match->edge.match.detail, HasSubstr("tape"));
  EXPECT_EQ(match->edge.robot_b, kBob);
  EXPECT_TRUE(match->edge.in_tree);
  ASSERT_TRUE(match->edge.manual_decision.has_value());
  EXPECT_EQ(match->edge.manual_decision->kind, ManualDecisionKind::kSet);
  pipeline->WaitUntilIdle();
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 1u);
  EXPECT_TRUE(Near(pipeline->reader().GetTransform(kAlice, kBob)->T_a_b, kGiven));
  ASSERT_EQ(CountVerdicts(*pipeline), 1);
  EXPECT_EQ(pipeline->reader().Map()->component_count(), 1u);

  ASSERT_TRUE(pipeline->decisions().DecideMatch({.robot_a = kAlice, .robot_b = kBob}).ok());
  pipeline->WaitUntilIdle();
  EXPECT_EQ(pipeline->GetMapInfo().components.size(), 2u);
  EXPECT_EQ(CountVerdicts(*pipeline), 0);
  const Match after = pipeline->reader().GetMatchGraph().matches.at(0).match;
  EXPECT_EQ(after.state, before.state);
  EXPECT_EQ(after.reason, before.reason);
  const RobotTrajectory again =
      pipeline->reader().GetTrajectory(kBob, TrajectoryFrame::kMap).value();
  EXPECT_TRUE(Near(again.poses[1].pose, bob.poses[1].pose));
}

TEST(PipelineManualDecisions, WhatWasFoundCanBeAccepted) {
  const auto pipeline = OpenInMemory();
  AddWalls(*pipeline);
  const Match found = pipeline->reader().GetMatchGraph().matches.at(0).match;
  ASSERT_NE(found.matcher, GuessSource::kNone) << "two equal walls lie on each other somewhere";
  const auto match = pipeline->decisions().DecideMatch(
      {.robot_a = kAlice, .robot_b = kBob, .kind = ManualDecisionKind::kAccept});
  ASSERT_TRUE(match.ok()) << match.status();
  EXPECT_TRUE(Near(match->edge.match.T_a_b, found.T_a_b));
  EXPECT_TRUE(Near(pipeline->reader().GetTransform(kAlice, kBob)->T_a_b, found.T_a_b));
}

TEST(PipelineManualDecisions, SidesAreTakenAsTheyAreNamed) {
  const auto pipeline = OpenInMemory();
  AddWalls(*pipeline);
  const MatchDecision decision{
      .robot_a = kBob, .robot_b = kAlice, .kind = ManualDecisionKind::kSet, .T_a_b = kGiven};
  ASSERT_TRUE(pipeline->decisions().DecideMatch(decision).ok());
  EXPECT_TRUE(Near(pipeline->reader().GetTransform(kBob, kAlice)->T_a_b, kGiven));
}

TEST(PipelineManualDecisions, HoldWhatIsComputedLaterAndRejectedPairsStayApart) {
  const auto pipeline = OpenInMemory();
  AddWalls(*pipeline);
  const MatchDecision given{
      .robot_a = kAlice, .robot_b = kBob, .kind = ManualDecisionKind::kSet, .T_a_b = kGiven};
  ASSERT_TRUE(pipeline->decisions().DecideMatch(given).ok());
  // A finished session's pair is estimated again.
  for (const SessionStatus& session : pipeline->sessions().List()) {
    ASSERT_TRUE(pipeline->sessions().Finish(session.record.id).ok());
  }
  pipeline->WaitUntilIdle();
  EXPECT_TRUE(Near(pipeline->reader().GetTransform(kAlice, kBob)->T_a_b, kGiven));
  ASSERT_TRUE(
      pipeline->decisions()
          .DecideMatch({.robot_a = kAlice, .robot_b = kBob, .kind = ManualDecisionKind::kReject})
          .ok());
  const absl::Status apart = pipeline->reader().GetTransform(kAlice, kBob).status();
  EXPECT_EQ(apart.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(apart.message()), HasSubstr("rejected by hand"));
}

TEST(PipelineManualDecisions, SurviveARestart) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                       ("isthmus_manual_decisions_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto open = [&] {
    return Pipeline::Open(QuickOptions(), storage::OpenSqliteStore(folder.string()).value())
        .value();
  };
  {
    const auto pipeline = open();
    AddWalls(*pipeline);
    const MatchDecision given{
        .robot_a = kAlice, .robot_b = kBob, .kind = ManualDecisionKind::kSet, .T_a_b = kGiven};
    ASSERT_TRUE(pipeline->decisions().DecideMatch(given).ok());
  }
  {
    const auto pipeline = open();
    pipeline->WaitUntilIdle();
    EXPECT_TRUE(Near(pipeline->reader().GetTransform(kAlice, kBob)->T_a_b, kGiven));
  }
  std::filesystem::remove_all(folder);
}

TEST(PipelineManualDecisions, AreRefusedWhereTheyMeanNothing) {
  const auto pipeline = OpenInMemory();
  AddWalls(*pipeline);
  const auto code = [&](const MatchDecision& decision) {
    return pipeline->decisions().DecideMatch(decision).status().code();
  };
  EXPECT_EQ(code({.robot_a = kAlice, .robot_b = RobotId("nobody")}), absl::StatusCode::kNotFound);
  EXPECT_EQ(code({.robot_a = kAlice, .session_b = SessionId("bob-9")}),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(code({.robot_a = kAlice, .robot_b = kAlice}), absl::StatusCode::kInvalidArgument);
  // A robot that has sent nothing was compared with nobody.
  ASSERT_TRUE(pipeline->sessions().Create({RobotId("carol"), "vlp16"}).ok());
  EXPECT_EQ(
      code({.robot_a = kAlice, .robot_b = RobotId("carol"), .kind = ManualDecisionKind::kAccept}),
      absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(code({.robot_a = kAlice,
                  .robot_b = kBob,
                  .kind = ManualDecisionKind::kSet,
                  .T_a_b = Pose(Eigen::Vector3d(std::nan(""), 0, 0))}),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(CountVerdicts(*pipeline), 0);
}

}  // namespace
}  // namespace isthmus::server
