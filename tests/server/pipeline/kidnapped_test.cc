// A robot that is carried to where it has never been goes on in a new segment, and once it has seen
// enough of what it saw before, both lie in one map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

constexpr int kBefore = 300;  // Scans of robot 0's drive; robot 1's begins where that has not been.

TEST(PipelineKidnapped, BothSegmentsLieInOneMapOnceTheyOverlap) {
  simulation::Options options;
  options.world = "museum";
  options.seconds = 60;
  options.seed = 4;
  const auto simulator = simulation::Simulator::Create(options).value();
  auto pipeline = OpenInMemory({});
  const RobotId alice("alice");
  const SessionId session = pipeline->sessions().Create({alice, "vlp16"}).value().record.id;
  AckLog log;
  ASSERT_TRUE(pipeline->sessions().SetAckSink(session, log.Sink()).ok());
  uint64_t sequence = 0;
  for (const auto& [robot, count] :
       {std::pair(0, kBefore), std::pair(1, simulator->scan_count())}) {
    for (int i = 0; i < count; ++i) {
      const auto stamp_ns = static_cast<int64_t>(++sequence) * 100'000'000;
      const PointPayload payload = codec::MakePayload(simulator->MakeScan(robot, i));
      ASSERT_TRUE(pipeline->sessions().SubmitScan(session, {sequence, stamp_ns, payload}).ok());
    }
  }
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  pipeline->WaitUntilIdle();

  const std::vector<ScanAck> acks = log.Take();
  const auto second =
      std::find_if(acks.begin(), acks.end(), [](const ScanAck& ack) { return ack.segment > 1; });
  ASSERT_NE(second, acks.end());
  EXPECT_EQ(second->segment_session, SegmentId(session, 2));
  EXPECT_LT(second->sequence, kBefore + 40u) << "told at once, not when it is too late";
  EXPECT_EQ(acks.back().segment, 2u);
  const std::vector<SessionStatus> sessions = pipeline->sessions().List();
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_EQ(sessions[0].segments, 2u);
  EXPECT_EQ(sessions[0].scans.ok + sessions[0].scans.degenerate + sessions[0].scans.lost, sequence);
  EXPECT_EQ(sessions[0].scans.rejected, 0u);

  const auto matches = pipeline->reader().GetMatchGraph().matches;
  ASSERT_EQ(matches.size(), 1u);
  ASSERT_EQ(matches[0].match.state, MatchState::kAccepted) << matches[0].match.detail;
  ASSERT_EQ(pipeline->GetMapInfo().components.size(), 1u);
  const RobotTrajectory trajectory =
      pipeline->reader().GetTrajectory(alice, TrajectoryFrame::kMap).value();
  ASSERT_EQ(trajectory.parts.size(), 2u);
  const Pose T_map_world = trajectory.poses[0].pose * simulator->Truth(0, 0).pose.Inverse();
  const size_t first_of_second = trajectory.parts[0].count;
  EXPECT_EQ(first_of_second, 0u + kBefore);
  double sum = 0;
  for (size_t k = first_of_second; k < trajectory.poses.size(); ++k) {
    const auto turn = static_cast<int>(trajectory.poses[k].stamp_ns / 100'000'000) - 1 - kBefore;
    const Pose truth = T_map_world * simulator->Truth(1, turn).pose;
    sum += (trajectory.poses[k].pose.translation() - truth.translation()).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(trajectory.parts[1].count)), 0.2);
}

}  // namespace
}  // namespace isthmus::server
