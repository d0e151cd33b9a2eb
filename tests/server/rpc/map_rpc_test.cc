// The RPCs that read the map, over a socket: requests arrive, answers come back.
#include "core/io/crc32c.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

class MapRpcTest : public RpcTest {
 protected:
  grpc::Status Trajectory(v1::Frame frame, std::vector<v1::GetTrajectoryResponse>* responses,
                          uint32_t segment = 0) {
    v1::GetTrajectoryRequest request;
    request.set_robot("alice");
    request.set_frame(frame);
    request.set_segment(segment);
    const auto context = NewContext();
    auto reader = stubs_->map->GetTrajectory(context.get(), request);
    v1::GetTrajectoryResponse response;
    while (reader->Read(&response)) responses->push_back(response);
    return reader->Finish();
  }
};

TEST_F(MapRpcTest, MapInfoNamesRobotsOfComponents) {
  const std::string alice = stubs_->NewSession("alice");
  const std::string bob = stubs_->NewSession("bob");
  Component component;
  component.reference = SessionId(alice);
  component.sessions = {SessionId(alice), SessionId(bob)};
  component.robots = {RobotId("alice"), RobotId("bob")};
  component.point_count = 12;
  component.bounds.Extend(Eigen::Vector3d(-1, -2, -3));
  component.bounds.Extend(Eigen::Vector3d(1, 2, 3));
  Component empty;
  empty.component = 1;
  pipeline_.info.revision = 5;
  pipeline_.info.robots = {RobotId("alice"), RobotId("bob")};
  pipeline_.info.components = {component, empty};
  pipeline_.info.settled = true;
  pipeline_.info.composition_ms = 1.5;
  pipeline_.info.composition_max_ms = 2.5;
  pipeline_.info.estimation_ms = 20.5;
  pipeline_.info.compositions = 3;
  pipeline_.info.estimations = 4;
  pipeline_.info.placement_ms = 6.5;
  pipeline_.info.placements = 7;
  pipeline_.info.submaps = 8;
  pipeline_.info.retired = 9;
  v1::MapInfo info;
  EXPECT_GRPC_OK(stubs_->map->GetMapInfo(NewContext().get(), {}, &info));
  EXPECT_EQ(info.revision(), 5);
  EXPECT_THAT(info.robots(), testing::ElementsAre("alice", "bob"));
  ASSERT_EQ(info.components_size(), 2);
  EXPECT_EQ(info.components(0).reference_session(), alice);
  EXPECT_THAT(info.components(0).sessions(), testing::ElementsAre(alice, bob));
  EXPECT_THAT(info.components(0).robots(), testing::ElementsAre("alice", "bob"));
  EXPECT_EQ(info.components(0).point_count(), 12u);
  EXPECT_EQ(info.components(0).bounds().min().y(), -2);
  EXPECT_EQ(info.components(0).bounds().max().z(), 3);
  EXPECT_EQ(info.components(1).component(), 1u);
  EXPECT_FALSE(info.components(1).has_bounds());
  EXPECT_TRUE(info.settled());
  EXPECT_EQ(info.composition_ms(), 1.5);
  EXPECT_EQ(info.composition_max_ms(), 2.5);
  EXPECT_EQ(info.estimation_ms(), 20.5);
  EXPECT_EQ(info.compositions(), 3u);
  EXPECT_EQ(info.estimations(), 4u);
  EXPECT_EQ(info.placement_ms(), 6.5);
  EXPECT_EQ(info.placements(), 7u);
  EXPECT_EQ(info.submaps(), 8u);
  EXPECT_EQ(info.retired(), 9u);
}

TEST_F(MapRpcTest, SubmapsOfAllRobotsOrOne) {
  for (const char* robot : {"alice", "bob"}) {
    Submap submap;
    submap.id = {SessionId(std::string(robot) + "-1"), 0};
    submap.robot = RobotId(robot);
    submap.keyframes.resize(2);
    submap.points = {{1, 2, 3, 0, 0}, {-1, 0, 4, 0, 1}};
    ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
  }
  pipeline_.placed["bob-1/0"] = Pose(Eigen::Vector3d(4, 5, 6));
  v1::ListSubmapsResponse response;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListSubmaps(NewContext().get(), {}), &response));
  ASSERT_EQ(response.submaps_size(), 2);
  EXPECT_FALSE(response.submaps(0).has_component()) << "not placed yet";
  EXPECT_FALSE(response.submaps(0).has_t_map_submap());
  EXPECT_EQ(response.submaps(1).component(), 1u);
  EXPECT_EQ(response.submaps(1).t_map_submap().translation().y(), 5);
  v1::ListSubmapsRequest request;
  request.set_robot("bob");
  EXPECT_GRPC_OK(Merged(stubs_->map->ListSubmaps(NewContext().get(), request), &response));
  ASSERT_EQ(response.submaps_size(), 1);
  EXPECT_EQ(response.submaps(0).session(), "bob-1");
  EXPECT_EQ(response.submaps(0).keyframe_count(), 2u);
  EXPECT_EQ(response.submaps(0).point_count(), 2u);
  EXPECT_EQ(response.submaps(0).bounds().min().x(), -1);
  request.set_robot("carol");
  EXPECT_GRPC_ERROR(Merged(stubs_->map->ListSubmaps(NewContext().get(), request), &response),
                    NOT_FOUND, "robot");
}

TEST_F(MapRpcTest, ALongTrajectoryComesInChunksInOrder) {
  RobotTrajectory trajectory{SessionId("alice-1"), 9, 2, {}};
  for (int i = 0; i < 60'000; ++i) trajectory.poses.push_back({i, Pose(Eigen::Vector3d(i, 0, 0))});
  pipeline_.trajectory = trajectory;
  std::vector<v1::GetTrajectoryResponse> responses;
  EXPECT_GRPC_OK(Trajectory(v1::MAP, &responses));
  ASSERT_GT(responses.size(), 1u);
  int next = 0;
  for (const auto& response : responses) {
    EXPECT_EQ(response.revision(), 9);
    EXPECT_EQ(response.session(), "alice-1");
    EXPECT_EQ(response.component(), 2u);
    EXPECT_LT(response.ByteSizeLong(), 2u << 20);
    for (const auto& pose : response.poses()) EXPECT_EQ(pose.stamp_ns(), next++);
  }
  EXPECT_EQ(next, 60'000);
}

TEST_F(MapRpcTest, NoResponseHasPosesOfTwoSegments) {
  RobotTrajectory trajectory{SessionId("alice-1"), 9, 2, {}};
  for (int i = 0; i < 1500; ++i) trajectory.poses.push_back({i, Pose()});
  trajectory.parts = {{1, 1200}, {3, 300}};
  trajectory.left_out = {2, 4};
  pipeline_.trajectory = trajectory;
  std::vector<v1::GetTrajectoryResponse> responses;
  EXPECT_GRPC_OK(Trajectory(v1::MAP, &responses, 5));
  EXPECT_EQ(pipeline_.trajectory_segment, 5u);
  ASSERT_EQ(responses.size(), 2u);
  const std::vector<std::pair<uint32_t, int>> expected = {{1, 1200}, {3, 300}};
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(responses[i].segment(), expected[i].first);
    EXPECT_EQ(responses[i].poses_size(), expected[i].second);
    ASSERT_EQ(responses[i].segments_left_out_size(), 2);
    EXPECT_EQ(responses[i].segments_left_out(1), 4u);
  }
}

TEST_F(MapRpcTest, ATrajectoryWithoutPosesStillNamesItsSession) {
  pipeline_.trajectory = RobotTrajectory{SessionId("alice-1"), 1, 0, {}};
  std::vector<v1::GetTrajectoryResponse> responses;
  EXPECT_GRPC_OK(Trajectory(v1::ODOM, &responses));
  ASSERT_EQ(responses.size(), 1u);
  EXPECT_EQ(responses[0].session(), "alice-1");
}

TEST_F(MapRpcTest, TrajectoryErrors) {
  std::vector<v1::GetTrajectoryResponse> responses;
  EXPECT_GRPC_ERROR(Trajectory(v1::FRAME_UNSPECIFIED, &responses), INVALID_ARGUMENT, "ODOM or MAP");
  EXPECT_GRPC_ERROR(Trajectory(static_cast<v1::Frame>(9), &responses), INVALID_ARGUMENT,
                    "ODOM or MAP");
  EXPECT_GRPC_ERROR(Trajectory(v1::ODOM, &responses), NOT_FOUND, "robot");
  pipeline_.trajectory = absl::FailedPreconditionError("not placed yet");
  EXPECT_GRPC_ERROR(Trajectory(v1::MAP, &responses), FAILED_PRECONDITION, "not placed");
  EXPECT_TRUE(responses.empty());
}

TEST_F(MapRpcTest, TheMatchGraphTellsWhichMatchesCarryTheMap) {
  const SessionId alice(stubs_->NewSession("alice"));
  const SessionId bob(stubs_->NewSession("bob"));
  const SessionId carol(stubs_->NewSession("carol"));
  Match accepted;
  accepted.a = alice;
  accepted.b = bob;
  accepted.T_a_b = Pose(Eigen::Vector3d(1, 2, 3));
  accepted.state = MatchState::kAccepted;
  accepted.reason = MatchReason::kOk;
  accepted.confidence = 0.75;
  accepted.inliers = 321;
  accepted.stages = {{"fpfh", 12.5}};
  Match rejected;
  rejected.a = alice;
  rejected.b = carol;
  rejected.state = MatchState::kRejected;
  rejected.reason = MatchReason::kFreeSpace;
  rejected.detail = "a wall stands where alice looked through";
  pipeline_.graph.revision = 4;
  pipeline_.graph.matches = {{accepted, RobotId("alice"), RobotId("bob"), true},
                             {rejected, RobotId("alice"), RobotId("carol")}};
  pipeline_.graph.placements = {{{bob, 0, alice, Pose(Eigen::Vector3d(0, 0, 1))}, RobotId("bob")}};
  v1::GetMatchGraphResponse graph;
  EXPECT_GRPC_OK(Merged(stubs_->map->GetMatchGraph(NewContext().get(), {}), &graph));
  EXPECT_EQ(graph.revision(), 4);
  ASSERT_EQ(graph.matches_size(), 2);
  const v1::Match& first = graph.matches(0);
  EXPECT_TRUE(first.in_tree());
  EXPECT_EQ(first.state(), v1::Match::ACCEPTED);
  EXPECT_EQ(first.robot_a(), "alice");
  EXPECT_EQ(first.robot_b(), "bob");
  EXPECT_EQ(first.t_a_b().translation().z(), 3);
  EXPECT_EQ(first.confidence(), 0.75);
  EXPECT_EQ(first.inliers(), 321);
  EXPECT_EQ(first.overlap(), -1);
  EXPECT_EQ(first.stages(0).stage(), "fpfh");
  EXPECT_FALSE(graph.matches(1).in_tree());
  EXPECT_EQ(graph.matches(1).state(), v1::Match::REJECTED);
  EXPECT_EQ(graph.matches(1).reason(), v1::Match::REASON_FREE_SPACE);
  ASSERT_EQ(graph.placements_size(), 1);
  EXPECT_EQ(graph.placements(0).robot(), "bob");
  EXPECT_EQ(graph.placements(0).reference_session(), alice.value());
}

TEST_F(MapRpcTest, AMatchComesWithEveryNumberItRestsOn) {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.overlap = 0.5;
  match.inlier_ratio = 0.75;
  match.shared_area_m2 = 321;
  match.observability = 0.0625;
  match.odometry_residual = 1.5;
  match.cycle_m = 0.25;
  match.cycle_deg = 2;
  match.candidates = 9;
  match.submaps_a = 3;
  match.submaps_b = 4;
  pipeline_.graph.matches = {{match}, {}};
  v1::GetMatchGraphResponse graph;
  EXPECT_GRPC_OK(Merged(stubs_->map->GetMatchGraph(NewContext().get(), {}), &graph));
  ASSERT_EQ(graph.matches_size(), 2);
  const v1::Match& read = graph.matches(0);
  EXPECT_EQ(read.overlap(), 0.5);
  EXPECT_EQ(read.inlier_ratio(), 0.75);
  EXPECT_EQ(read.shared_area_m2(), 321);
  EXPECT_EQ(read.observability(), 0.0625);
  EXPECT_EQ(read.odometry_residual(), 1.5);
  EXPECT_EQ(read.cycle_m(), 0.25);
  EXPECT_EQ(read.cycle_deg(), 2);
  EXPECT_EQ(read.candidates(), 9u);
  EXPECT_EQ(read.submaps_a(), 3u);
  EXPECT_EQ(read.submaps_b(), 4u);
  const v1::Match& unknown = graph.matches(1);
  for (const double value :
       {unknown.inlier_ratio(), unknown.shared_area_m2(), unknown.observability(),
        unknown.odometry_residual(), unknown.cycle_m(), unknown.cycle_deg()}) {
    EXPECT_EQ(value, -1) << "not computed";
  }
}

TEST_F(MapRpcTest, EdgesOfMatchesComeOnlyIfAskedFor) {
  Match match;
  match.a = SessionId("alice-1");
  match.b = SessionId("bob-1");
  match.edges.resize(2);
  match.edges[1].submap_a = 7;
  match.edges[1].submap_b = 3;
  match.edges[1].T_a_b = Pose(Eigen::Vector3d(1, 2, 3));
  match.edges[1].information.diagonal() << 1, 2, 3, 4, 5, 6;
  match.edges[1].information(0, 5) = match.edges[1].information(5, 0) = 9;
  pipeline_.graph.matches = {{match}};
  v1::GetMatchGraphRequest request;
  v1::GetMatchGraphResponse graph;
  EXPECT_GRPC_OK(Merged(stubs_->map->GetMatchGraph(NewContext().get(), request), &graph));
  EXPECT_EQ(graph.matches(0).edges_size(), 0);
  request.set_include_edges(true);
  EXPECT_GRPC_OK(Merged(stubs_->map->GetMatchGraph(NewContext().get(), request), &graph));
  ASSERT_EQ(graph.matches(0).edges_size(), 2);
  const v1::SubmapEdge& edge = graph.matches(0).edges(1);
  EXPECT_EQ(edge.submap_a(), 7u);
  EXPECT_EQ(edge.submap_b(), 3u);
  EXPECT_EQ(edge.t_a_b().translation().y(), 2);
  EXPECT_THAT(edge.information(),
              testing::ElementsAre(1, 0, 0, 0, 0, 9, 2, 0, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 5, 0, 6));
}

TEST_F(MapRpcTest, TransformOrWhyThereIsNone) {
  v1::GetTransformRequest request;
  v1::GetTransformResponse response;
  EXPECT_GRPC_ERROR(stubs_->map->GetTransform(NewContext().get(), request, &response), NOT_FOUND,
                    "robot");
  pipeline_.transform = absl::FailedPreconditionError("LOW_OVERLAP: 3 % of 10 %");
  EXPECT_GRPC_ERROR(stubs_->map->GetTransform(NewContext().get(), request, &response),
                    FAILED_PRECONDITION, "LOW_OVERLAP");
  pipeline_.transform = RobotTransform{3, Pose(Eigen::Vector3d(7, 0, 0))};
  EXPECT_GRPC_OK(stubs_->map->GetTransform(NewContext().get(), request, &response));
  EXPECT_EQ(response.revision(), 3);
  EXPECT_EQ(response.t_a_b().translation().x(), 7);
}

}  // namespace
}  // namespace isthmus::rpc
