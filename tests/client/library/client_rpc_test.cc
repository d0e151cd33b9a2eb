// The client with the real RPC layer over a real socket; behind it a pipeline that answers what the
// test says, so that every number can be followed from one end to the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "client/library/client.h"
#include "core/codec/payload_builder.h"
#include "core/concurrency/mutex.h"
#include "server/rpc/server.h"
#include "tests/client/library/poses.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::client {
namespace {

using testing::ElementsAre;

class ClientRpcTest : public testing::Test {
 protected:
  void SetUp() override {
    StartServer();
    ClientOptions options;
    options.address = server_->address();
    options.sleep = [this](double) { MutexLock wait_for_restart(&restarting_); };
    auto client = Client::Connect(options);
    ASSERT_TRUE(client.ok()) << client.status();
    client_ = *std::move(client);
  }

  void StartServer() {
    rpc::ServerOptions options;
    options.listen = "127.0.0.1:" + std::to_string(port_);
    auto server = rpc::RpcServer::Start(&pipeline_, options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    port_ = server_->port();
  }

  rpc::FakePipeline pipeline_;
  Mutex restarting_;  // Held while there is no server.
  int port_ = 0;
  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<Client> client_;
};

TEST_F(ClientRpcTest, TheServerSaysHowItIsGettingOn) {
  {
    MutexLock lock(&pipeline_.load_mutex);
    pipeline_.load.revision = 12;
    pipeline_.load.storage_problem = "no room";
  }
  const auto status = client_->GetStatus();
  ASSERT_TRUE(status.ok()) << status.status();
  EXPECT_EQ(status->site, "default");
  EXPECT_EQ(status->load.revision, 12);
  EXPECT_EQ(status->load.storage_problem, "no room");
  EXPECT_EQ(status->degraded.size(), 2u);
  EXPECT_GT(status->process.resident_bytes, 0u);
}

TEST_F(ClientRpcTest, SessionsComeAndGo) {
  const auto session = client_->CreateSession("alice", "vlp16", kPose);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->record.robot, RobotId("alice"));
  EXPECT_EQ(session->record.sensor, "vlp16");
  ExpectEqual(session->record.T_base_sensor, kPose);
  EXPECT_FALSE(session->component.has_value());
  EXPECT_EQ(client_->ListSessions()->size(), 1u);
  EXPECT_EQ(client_->FinishSession(session->record.id)->record.state, SessionState::kFinished);
  EXPECT_EQ(client_->GetSession(session->record.id)->record.state, SessionState::kFinished);
  EXPECT_TRUE(client_->DeleteSession(session->record.id).ok());
  EXPECT_TRUE(absl::IsNotFound(client_->DeleteSession(session->record.id)));
}

TEST_F(ClientRpcTest, ScansGoUpAndAcknowledgementsComeDown) {
  const SessionId id = client_->CreateSession("alice", "vlp16")->record.id;
  std::vector<ScanAck> acks;
  const auto stream = client_->OpenScanStream(
      id, {.resolution_m = 0.002, .on_ack = [&](const ScanAck& ack) { acks.push_back(ack); }});
  ASSERT_TRUE(stream.ok()) << stream.status();
  for (int i = 1; i <= 100; ++i) {
    ASSERT_TRUE((*stream)->Push(i, codec::MakePayload(Cloud(100, {1, 2, 3, 4}))).ok());
  }
  ASSERT_TRUE((*stream)->Finish().ok());
  ASSERT_EQ(acks.size(), 100u);
  EXPECT_EQ(acks[41].sequence, 42u);
  EXPECT_EQ(acks[41].end_stamp_ns, 42);
  EXPECT_EQ(acks[41].tracking, Tracking::kOk);
  ExpectEqual(*acks[41].T_odom_sensor, Pose(Eigen::Vector3d(42, 0, 0)));
  EXPECT_EQ(acks[41].timing.total_ms, 3.5);
  EXPECT_EQ(acks[41].segment, 2u);
  EXPECT_EQ(acks[41].segment_session, SegmentId(acks[41].session, 2));
  EXPECT_EQ(acks[41].lost_since_ns, 7);
  EXPECT_EQ(acks[41].scans, (ScanCounts{11, 12, 13, 14}));
  ASSERT_TRUE(acks[41].covariance);
  EXPECT_EQ((*acks[41].covariance)(1, 3), 13);
  EXPECT_EQ((*acks[41].covariance)(3, 1), 13);
  ASSERT_EQ(acks[41].unobserved_translations.size(), 2u);
  EXPECT_EQ(acks[41].unobserved_translations[1], Eigen::Vector3d(0, 0.6, 0.8));
  ASSERT_EQ(acks[41].unobserved_rotations.size(), 1u);
}

TEST_F(ClientRpcTest, ARestartOfTheServerLosesAndDoublesNothing) {
  const SessionId id = client_->CreateSession("alice", "vlp16")->record.id;
  std::vector<uint64_t> acked;
  const auto stream = client_->OpenScanStream(
      id, {.on_ack = [&](const ScanAck& ack) { acked.push_back(ack.sequence); }});
  ASSERT_TRUE(stream.ok()) << stream.status();
  const PointPayload payload = codec::MakePayload(Cloud(100, {1, 2, 3, 4}));
  pipeline_.Hold(16);
  for (int i = 1; i <= 8; ++i) ASSERT_TRUE((*stream)->Push(i, payload).ok());
  pipeline_.WaitForQueued(8);
  {
    MutexLock restarting(&restarting_);
    std::thread shutdown([this] { server_->Shutdown(std::chrono::milliseconds(0)); });
    pipeline_.Release();  // Some acknowledgements get through, others do not.
    shutdown.join();
    server_.reset();
    StartServer();
  }
  for (int i = 9; i <= 20; ++i) ASSERT_TRUE((*stream)->Push(i, payload).ok());
  ASSERT_TRUE((*stream)->Finish().ok());
  ASSERT_EQ(acked.size(), 20u);
  for (uint64_t i = 0; i < acked.size(); ++i) EXPECT_EQ(acked[i], i + 1);
  EXPECT_EQ(client_->GetSession(id)->last_sequence, 20u);
}

TEST_F(ClientRpcTest, AFinishedSessionTakesNoScans) {
  const SessionId id = client_->CreateSession("alice", "vlp16")->record.id;
  ASSERT_TRUE(client_->FinishSession(id).ok());
  const absl::Status opened = client_->OpenScanStream(id).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(opened)) << opened;
}

TEST_F(ClientRpcTest, SubmapsArriveAsTheyWereSent) {
  const SessionId id = client_->CreateSession("alice", "vlp16")->record.id;
  SubmapUpload submap;
  submap.id = {id, 0};
  submap.first_stamp_ns = 5;
  submap.last_stamp_ns = 6;
  submap.T_odom_submap = kPose;
  submap.keyframes = {{5, kPose}};
  submap.cloud = codec::MakePayload(Cloud(150'000, {1, 2, 3, 4}));
  ASSERT_TRUE(client_->UploadSubmap(submap).ok());
  const std::vector<Submap> taken = pipeline_.submaps();
  ASSERT_EQ(taken.size(), 1u);
  ExpectEqual(taken[0].T_odom_submap, kPose);
  ASSERT_EQ(taken[0].keyframes.size(), 1u);
  ExpectEqual(taken[0].keyframes[0].T_submap_sensor, kPose);
  ASSERT_EQ(taken[0].points.size(), 150'000u);
  EXPECT_EQ(taken[0].points.back().z, 3);
}

TEST_F(ClientRpcTest, TheMapsInfoIsReadInFull) {
  MapInfo& info = pipeline_.info;
  info.revision = 12;
  info.robots = {RobotId("alice"), RobotId("bob")};
  info.settled = true;
  info.composition_ms = 1.5;
  info.estimations = 4;
  info.placement_ms = 2.5;
  info.placements = 5;
  info.submaps = 6;
  info.retired = 7;
  Component component;
  component.reference = SessionId("alice-1");
  component.sessions = {SessionId("alice-1"), SessionId("bob-1")};
  component.point_count = 99;
  component.bounds = Box{{-1, -2, -3}, {1, 2, 3}};
  info.components = {component};
  const auto read = client_->GetMapInfo();
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->revision, 12);
  EXPECT_EQ(read->robots, info.robots);
  EXPECT_TRUE(read->settled);
  EXPECT_EQ(read->composition_ms, 1.5);
  EXPECT_EQ(read->estimations, 4u);
  EXPECT_EQ(read->placement_ms, 2.5);
  EXPECT_EQ(read->placements, 5u);
  EXPECT_EQ(read->submaps, 6u);
  EXPECT_EQ(read->retired, 7u);
  ASSERT_EQ(read->components.size(), 1u);
  EXPECT_EQ(read->components[0].reference, SessionId("alice-1"));
  EXPECT_EQ(read->components[0].sessions, component.sessions);
  EXPECT_EQ(read->components[0].point_count, 99u);
  EXPECT_EQ(read->components[0].bounds.max, Eigen::Vector3d(1, 2, 3));
}

TEST_F(ClientRpcTest, TheMatchGraphKeepsItsReasons) {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.T_a_b = kPose;
  match.state = MatchState::kAmbiguous;
  match.reason = MatchReason::kAmbiguous;
  match.detail = "two rooms look alike";
  match.confidence = 0.25;
  match.inliers = 321;
  match.stages = {{"fpfh", 12.5}, {"vgicp", 7}};
  pipeline_.graph.revision = 3;
  pipeline_.graph.matches = {{match}};
  pipeline_.graph.placements = {{{SessionId("alice-1"), 1, SessionId("alice-1"), kPose}, {}}};
  const auto graph = client_->GetMatchGraph();
  ASSERT_TRUE(graph.ok()) << graph.status();
  ASSERT_EQ(graph->matches.size(), 1u);
  const Match& read = graph->matches[0].match;
  EXPECT_EQ(read.state, MatchState::kAmbiguous);
  EXPECT_EQ(read.reason, MatchReason::kAmbiguous);
  EXPECT_EQ(read.detail, match.detail);
  EXPECT_EQ(read.confidence, 0.25);
  EXPECT_EQ(read.inliers, 321);
  EXPECT_EQ(read.overlap, -1) << "not computed";
  ASSERT_EQ(read.stages.size(), 2u);
  EXPECT_EQ(read.stages[1].stage, "vgicp");
  ExpectEqual(read.T_a_b, kPose);
  EXPECT_FALSE(graph->matches[0].in_tree);
  ASSERT_EQ(graph->placements.size(), 1u);
  EXPECT_EQ(graph->placements[0].placement.component, 1u);
  ExpectEqual(graph->placements[0].placement.T_map_odom, kPose);
}

TEST_F(ClientRpcTest, AMatchComesWithEveryNumberAndItsEdgesIfAskedFor) {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.inlier_ratio = 0.75;
  match.shared_area_m2 = 321;
  match.observability = 0.0625;
  match.odometry_residual = 1.5;
  match.cycle_m = 0.25;
  match.candidates = 9;
  match.submaps_a = 3;
  match.submaps_b = 4;
  SubmapEdge edge;
  edge.submap_a = 7;
  edge.submap_b = 2;
  edge.T_a_b = kPose;
  edge.information.diagonal() << 1, 2, 3, 4, 5, 6;
  edge.information(1, 4) = edge.information(4, 1) = -7;
  match.edges = {edge};
  pipeline_.graph.matches = {{match}};
  const auto without = client_->GetMatchGraph();
  ASSERT_TRUE(without.ok()) << without.status();
  EXPECT_TRUE(without->matches.at(0).match.edges.empty());
  const auto with = client_->GetMatchGraph(true);
  ASSERT_TRUE(with.ok()) << with.status();
  const Match& read = with->matches.at(0).match;
  EXPECT_EQ(read.inlier_ratio, 0.75);
  EXPECT_EQ(read.shared_area_m2, 321);
  EXPECT_EQ(read.observability, 0.0625);
  EXPECT_EQ(read.odometry_residual, 1.5);
  EXPECT_EQ(read.cycle_m, 0.25);
  EXPECT_EQ(read.cycle_deg, -1) << "not computed";
  EXPECT_EQ(read.candidates, 9u);
  EXPECT_EQ(read.submaps_a, 3u);
  EXPECT_EQ(read.submaps_b, 4u);
  ASSERT_EQ(read.edges.size(), 1u);
  EXPECT_EQ(read.edges[0].submap_a, 7u);
  EXPECT_EQ(read.edges[0].submap_b, 2u);
  ExpectEqual(read.edges[0].T_a_b, kPose);
  EXPECT_EQ(read.edges[0].information, edge.information);
}

TEST_F(ClientRpcTest, ADecisionOnAMatchGoesUpAndTheMatchComesBack) {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.T_a_b = kPose;
  MatchEdge told{match};
  told.manual_decision = {match.a, match.b, ManualDecisionKind::kSet, kPose, "tape", 5};
  pipeline_.decided = DecidedMatch{9, told};
  MatchDecision decision;
  decision.robot_a = RobotId("alice");
  decision.session_b = SessionId("bob-1");
  decision.kind = ManualDecisionKind::kSet;
  decision.T_a_b = kPose;
  decision.note = "tape";
  const auto decided = client_->DecideMatch(decision);
  ASSERT_TRUE(decided.ok()) << decided.status();
  EXPECT_EQ(decided->revision, 9);
  const MatchEdge& edge = decided->edge;
  ASSERT_EQ(pipeline_.match_decisions.size(), 1u);
  EXPECT_EQ(pipeline_.match_decisions[0].robot_a, RobotId("alice"));
  EXPECT_EQ(pipeline_.match_decisions[0].session_b, SessionId("bob-1"));
  EXPECT_EQ(pipeline_.match_decisions[0].kind, ManualDecisionKind::kSet);
  EXPECT_EQ(pipeline_.match_decisions[0].note, "tape");
  ExpectEqual(pipeline_.match_decisions[0].T_a_b, kPose);
  ASSERT_TRUE(edge.manual_decision.has_value());
  EXPECT_EQ(edge.manual_decision->kind, ManualDecisionKind::kSet);
  EXPECT_EQ(edge.manual_decision->note, "tape");
  EXPECT_EQ(edge.manual_decision->given_ns, 5);
  ExpectEqual(edge.match.T_a_b, kPose);
  for (const ManualDecisionKind kind : {ManualDecisionKind::kAccept, ManualDecisionKind::kReject}) {
    decision.kind = kind;
    EXPECT_TRUE(client_->DecideMatch(decision).ok());
    EXPECT_EQ(pipeline_.match_decisions.back().kind, kind);
  }
  decision.kind.reset();
  EXPECT_TRUE(client_->DecideMatch(decision).ok());
  EXPECT_FALSE(pipeline_.match_decisions.back().kind.has_value());
}

TEST_F(ClientRpcTest, ALongTrajectoryComesInOneAnswer) {
  RobotTrajectory trajectory;
  trajectory.session = SessionId("alice-1");
  trajectory.revision = 8;
  for (int i = 0; i < 2500; ++i) trajectory.poses.push_back({i, Pose(Eigen::Vector3d(i, 0, 0))});
  pipeline_.trajectory = trajectory;
  const auto read = client_->GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->revision, 8);
  ASSERT_EQ(read->poses.size(), 2500u);
  EXPECT_EQ(read->poses[2222].stamp_ns, 2222);
  EXPECT_EQ(read->poses[2222].pose.translation().x(), 2222);
  ASSERT_EQ(read->parts.size(), 1u);
  EXPECT_EQ(read->parts[0].count, 2500u);
}

TEST_F(ClientRpcTest, ATrajectorySaysWhichSegmentsItIsOf) {
  RobotTrajectory trajectory;
  for (int i = 0; i < 1500; ++i) trajectory.poses.push_back({i, Pose()});
  trajectory.parts = {{1, 1200}, {3, 300}};
  trajectory.left_out = {2};
  pipeline_.trajectory = trajectory;
  const auto read = client_->GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap, 7);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(pipeline_.trajectory_segment, 7u);
  ASSERT_EQ(read->parts.size(), 2u);
  EXPECT_EQ(read->parts[0].segment, 1u);
  EXPECT_EQ(read->parts[0].count, 1200u);
  EXPECT_EQ(read->parts[1].segment, 3u);
  EXPECT_EQ(read->parts[1].count, 300u);
  EXPECT_EQ(read->left_out, std::vector<uint32_t>{2});
}

TEST_F(ClientRpcTest, TransformsAndWhyThereIsNone) {
  pipeline_.transform = RobotTransform{5, kPose};
  ExpectEqual(client_->GetTransform(RobotId("a"), RobotId("b"))->T_a_b, kPose);
  pipeline_.transform = absl::FailedPreconditionError("the best match lacks overlap");
  const auto none = client_->GetTransform(RobotId("a"), RobotId("b"));
  EXPECT_TRUE(absl::IsFailedPrecondition(none.status()));
  EXPECT_EQ(none.status().message(), "the best match lacks overlap");
  pipeline_.transform = absl::UnavailableError("the map is being composed");
  EXPECT_EQ(client_->GetTransform(RobotId("a"), RobotId("b")).status().message(),
            "the map is being composed")
      << "nobody is sent to look for a server that answers";
}

TEST_F(ClientRpcTest, ARegionIsReadPointByPoint) {
  pipeline_.map->robots_ = {RobotId("alice"), RobotId("bob")};
  pipeline_.map->components_ = 1;
  for (int i = 0; i < 100'000; ++i) {
    pipeline_.map->points_.push_back({i * 1.0f, 2, 3, 0.5f, static_cast<uint32_t>(i % 2)});
  }
  std::vector<MapPoint> points;
  std::vector<RobotId> robots;
  RegionQuery query;
  query.box = Box{{10, 0, 0}, {69'999, 10, 10}};
  const absl::Status status = client_->QueryRegion(query, [&](const RegionChunk& chunk) {
    EXPECT_EQ(chunk.revision, 7);
    robots = chunk.robots;
    points.insert(points.end(), chunk.points.begin(), chunk.points.end());
    return true;
  });
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_THAT(robots, ElementsAre(RobotId("alice"), RobotId("bob"))) << "also in the last chunk";
  ASSERT_EQ(points.size(), 69'990u);
  EXPECT_EQ(points[1].x, 11);
  EXPECT_EQ(points[1].intensity, 0.5f);
  EXPECT_EQ(points[1].robot, 1u);

  query.box = Box{{1, 0, 0}, {0, 1, 1}};
  EXPECT_TRUE(absl::IsInvalidArgument(
      client_->QueryRegion(query, [](const RegionChunk&) { return true; })));
  EXPECT_TRUE(
      absl::IsCancelled(client_->QueryRegion({}, [](const RegionChunk&) { return false; })));
}

TEST_F(ClientRpcTest, AnExportIsVerified) {
  pipeline_.map->components_ = 1;
  pipeline_.map->points_ = {{1, 2, 3, 4, 0}};
  pipeline_.file = {"first piece, ", std::string(2'000'000, 'x'), "last piece"};
  std::string file;
  const auto summary =
      client_->Export({.format = ExportFormat::kPly}, [&](const std::string& bytes) {
        file += bytes;
        return true;
      });
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(file, pipeline_.file[0] + pipeline_.file[1] + pipeline_.file[2]);
  EXPECT_EQ(summary->size, file.size());
  EXPECT_EQ(pipeline_.exports.at(0).format, ExportFormat::kPly);
}

}  // namespace
}  // namespace isthmus::client
