// Revisions, loop closures, anchors and the pose graph through the client: the real RPC layer over
// a real socket, behind it a pipeline that answers what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/client/library/client_fixture.h"
#include "tests/client/library/poses.h"

namespace isthmus::client {
namespace {

using testing::ElementsAre;

using ClientGraphTest = ClientTest;

RevisionInfo Info(int64_t revision) {
  RevisionInfo info;
  info.revision = revision;
  info.stamp_ns = 100 * revision;
  info.cause = "loop closure 3 of alice-1";
  info.matches = {{SessionId("alice-1"), SessionId("bob-1")}};
  info.loops = {3, 5};
  info.added = 1;
  info.moved = 2;
  info.removed = 4;
  info.largest_move_m = 0.5;
  return info;
}

void ExpectEqualInfo(const RevisionInfo& a, const RevisionInfo& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.stamp_ns, b.stamp_ns);
  EXPECT_EQ(a.cause, b.cause);
  EXPECT_EQ(a.matches, b.matches);
  EXPECT_EQ(a.loops, b.loops);
  EXPECT_EQ(a.added, b.added);
  EXPECT_EQ(a.moved, b.moved);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_EQ(a.largest_move_m, b.largest_move_m);
}

TEST_F(ClientGraphTest, SubmapsSayWhereTheyLie) {
  for (uint32_t index : {0u, 3u}) {
    Submap submap;
    submap.id = {SessionId("alice-1"), index};
    submap.robot = RobotId("alice");
    submap.T_odom_submap = kPose.Inverse();
    submap.keyframes.resize(2);
    submap.points = {{1, 2, 3, 0, 0}, {-1, 0, 4, 0, 1}};
    ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
  }
  pipeline_.placed["alice-1/3"] = kPose;
  const auto submaps = client_->ListSubmaps();
  ASSERT_TRUE(submaps.ok()) << submaps.status();
  ASSERT_EQ(submaps->size(), 2u);
  EXPECT_FALSE(submaps->at(0).component.has_value()) << "not placed yet";
  const SubmapStatus& placed = submaps->at(1);
  EXPECT_EQ(placed.info.id, (SubmapId{SessionId("alice-1"), 3}));
  EXPECT_EQ(placed.info.robot, RobotId("alice"));
  EXPECT_EQ(placed.info.keyframe_count, 2u);
  EXPECT_EQ(placed.info.point_count, 2u);
  EXPECT_EQ(placed.info.bounds.max, Eigen::Vector3d(1, 2, 4));
  ExpectEqual(placed.info.T_odom_submap, kPose.Inverse());
  EXPECT_EQ(placed.component, 1u);
  ExpectEqual(placed.T_map_submap, kPose);
  EXPECT_TRUE(absl::IsNotFound(client_->ListSubmaps(RobotId("carol")).status()));
}

TEST_F(ClientGraphTest, RevisionsAreReadInFull) {
  pipeline_.revisions = std::vector<RevisionInfo>{Info(9), Info(8)};
  const auto revisions = client_->ListRevisions(2);
  ASSERT_TRUE(revisions.ok()) << revisions.status();
  EXPECT_EQ(pipeline_.asked_limit, 2);
  ASSERT_EQ(revisions->size(), 2u);
  ExpectEqualInfo(revisions->at(0), Info(9));
  ExpectEqualInfo(revisions->at(1), Info(8));
  ASSERT_TRUE(client_->ListRevisions().ok());
  EXPECT_EQ(pipeline_.asked_limit, 100);
}

Loop SomeLoop() {
  Loop status;
  LoopClosure& loop = status.loop;
  loop.id = 17;
  loop.session = SessionId("alice-1");
  loop.submap_a = 2;
  loop.submap_b = 40;
  loop.T_a_b = kPose;
  loop.confidence = 0.75;
  loop.overlap = 0.5;
  loop.residual_m = 0.03;
  loop.free_space = 0.25;
  loop.comparisons = 9000;
  loop.source = GuessSource::kPlaces;
  loop.detail = "half of it lies on it";
  loop.computed_ns = 77;
  loop.rejected = true;
  loop.note = "why";
  loop.edges.resize(2);
  loop.edges[1].submap_a = 3;
  loop.edges[1].submap_b = 41;
  loop.edges[1].T_a_b = kPose;
  loop.edges[1].information(0, 5) = loop.edges[1].information(5, 0) = 9;
  status.robot = RobotId("alice");
  status.edge_count = 2;
  status.edges_used = 1;
  return status;
}

TEST_F(ClientGraphTest, ListsLongerThanAResponseArePutTogether) {
  constexpr uint32_t kEdges = 30'000;
  MatchEdge edge;
  edge.match.a = SessionId("alice-1");
  edge.match.b = SessionId("bob-1");
  edge.match.edges.resize(kEdges);
  for (uint32_t k = 0; k < kEdges; ++k) edge.match.edges[k].submap_a = k;
  pipeline_.graph.revision = 3;
  pipeline_.graph.matches = {edge, edge};
  const auto graph = client_->GetMatchGraph(true);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(graph->revision, 3);
  ASSERT_EQ(graph->matches.size(), 2u);
  for (const MatchEdge& read : graph->matches) {
    ASSERT_EQ(read.match.edges.size(), kEdges);
    for (uint32_t k = 0; k < kEdges; ++k) EXPECT_EQ(read.match.edges[k].submap_a, k);
  }
  Loop loop = SomeLoop();
  loop.loop.edges = edge.match.edges;
  pipeline_.loops = std::vector<Loop>{loop, loop};
  pipeline_.info.revision = 4;
  const auto loops = client_->ListLoops({}, true);
  ASSERT_TRUE(loops.ok()) << loops.status();
  EXPECT_EQ(loops->revision, 4);
  ASSERT_EQ(loops->size(), 2u);
  EXPECT_EQ(loops->at(0).loop.edges.size(), kEdges);
  EXPECT_EQ(loops->at(1).loop.edges.back().submap_a, kEdges - 1);
}

TEST_F(ClientGraphTest, ALargeDifferenceComesInOneAnswer) {
  RevisionDiff diff;
  diff.from = 4;
  diff.to = 9;
  diff.revisions = {Info(9), Info(5)};
  constexpr uint32_t kMoves = 30'000;  // In several responses.
  for (uint32_t i = 0; i < kMoves; ++i) {
    SubmapMove move;
    move.submap = {SessionId("alice-1"), i};
    if (i % 3 != 1) {
      move.before = kPose;
      move.frame_before = SessionId("alice-1");
    }
    if (i % 3 != 2) {
      move.after = kPose.Inverse();
      move.frame_after = SessionId("bob-1");
    }
    diff.moves.push_back(move);
  }
  pipeline_.diff = diff;
  const auto read = client_->DiffRevisions(4);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(pipeline_.asked_diff, std::make_pair(int64_t{4}, int64_t{0}));
  EXPECT_EQ(read->from, 4);
  EXPECT_EQ(read->to, 9);
  ASSERT_EQ(read->revisions.size(), 2u);
  ExpectEqualInfo(read->revisions[1], Info(5));
  ASSERT_EQ(read->moves.size(), kMoves);
  const SubmapMove& moved = read->moves[2400];
  EXPECT_EQ(moved.submap.index, 2400u);
  ASSERT_TRUE(moved.before && moved.after);
  ExpectEqual(*moved.before, kPose);
  ExpectEqual(*moved.after, kPose.Inverse());
  EXPECT_EQ(moved.frame_before, SessionId("alice-1"));
  EXPECT_EQ(moved.frame_after, SessionId("bob-1"));
  EXPECT_FALSE(read->moves[2401].before.has_value()) << "it came";
  EXPECT_FALSE(read->moves[2402].after.has_value()) << "it went";
  pipeline_.diff = absl::OutOfRangeError("the oldest that is kept is 7");
  EXPECT_TRUE(absl::IsOutOfRange(client_->DiffRevisions(1, 9).status()));
}

TEST_F(ClientGraphTest, ARevisionIsUndone) {
  pipeline_.undo = 12;
  const auto undone = client_->UndoRevision(9, "the twin stairwell");
  ASSERT_TRUE(undone.ok()) << undone.status();
  EXPECT_EQ(*undone, 12);
  EXPECT_THAT(pipeline_.undone, ElementsAre(std::make_pair(int64_t{9}, "the twin stairwell")));
  pipeline_.undo = absl::FailedPreconditionError("new submaps made it");
  EXPECT_EQ(client_->UndoRevision(8).status(), pipeline_.undo.status());
}

TEST_F(ClientGraphTest, LoopsAreReadInFull) {
  pipeline_.loops = std::vector<Loop>{SomeLoop()};
  const auto loops = client_->ListLoops(RobotId("alice"), true);
  ASSERT_TRUE(loops.ok()) << loops.status();
  EXPECT_EQ(pipeline_.asked_robot, RobotId("alice"));
  ASSERT_EQ(loops->size(), 1u);
  const LoopClosure& loop = loops->at(0).loop;
  EXPECT_EQ(loop.id, 17u);
  EXPECT_EQ(loop.session, SessionId("alice-1"));
  EXPECT_EQ(loop.submap_a, 2u);
  EXPECT_EQ(loop.submap_b, 40u);
  ExpectEqual(loop.T_a_b, kPose);
  EXPECT_EQ(loop.confidence, 0.75);
  EXPECT_EQ(loop.overlap, 0.5);
  EXPECT_EQ(loop.residual_m, 0.03);
  EXPECT_EQ(loop.free_space, 0.25);
  EXPECT_EQ(loop.comparisons, 9000);
  EXPECT_EQ(loop.source, GuessSource::kPlaces);
  EXPECT_EQ(loop.detail, "half of it lies on it");
  EXPECT_EQ(loop.computed_ns, 77);
  EXPECT_TRUE(loop.rejected);
  EXPECT_EQ(loop.note, "why");
  EXPECT_EQ(loops->at(0).edge_count, 2u);
  EXPECT_EQ(loops->at(0).edges_used, 1u);
  ASSERT_EQ(loop.edges.size(), 2u);
  EXPECT_EQ(loop.edges[1].submap_b, 41u);
  ExpectEqual(loop.edges[1].T_a_b, kPose);
  EXPECT_EQ(loop.edges[1].information(5, 0), 9);
  EXPECT_TRUE(client_->ListLoops()->at(0).loop.edges.empty()) << "not asked for";
  EXPECT_FALSE(pipeline_.asked_robot.has_value());
}

TEST_F(ClientGraphTest, ADecisionOnALoopGoesUpAndTheLoopComesBack) {
  pipeline_.decided_loop = DecidedLoop{11, SomeLoop()};
  const auto decided = client_->DecideLoop({.id = 17, .rejected = true, .note = "another floor"});
  ASSERT_TRUE(decided.ok()) << decided.status();
  EXPECT_EQ(decided->revision, 11);
  EXPECT_EQ(decided->loop.loop.id, 17u);
  EXPECT_TRUE(decided->loop.loop.rejected);
  ASSERT_TRUE(client_->DecideLoop({.id = 18, .rejected = false}).ok());
  ASSERT_EQ(pipeline_.loop_decisions.size(), 2u);
  EXPECT_EQ(pipeline_.loop_decisions[0].id, 17u);
  EXPECT_TRUE(pipeline_.loop_decisions[0].rejected);
  EXPECT_EQ(pipeline_.loop_decisions[0].note, "another floor");
  EXPECT_FALSE(pipeline_.loop_decisions[1].rejected);
  pipeline_.decided_loop = absl::NotFoundError("no loop closure 19");
  EXPECT_TRUE(absl::IsNotFound(client_->DecideLoop({.id = 19}).status()));
}

TEST_F(ClientGraphTest, AnchorsGoUpAndComeBack) {
  const SessionId session = client_->CreateSession("alice", "vlp16")->record.id;
  Anchor anchor;
  anchor.submap = {session, 7};
  anchor.T_map_submap = kPose;
  anchor.sigma_xy_m = 0.1;
  anchor.sigma_z_m = 0.2;
  anchor.sigma_deg = 3;
  anchor.note = "total station";
  EXPECT_TRUE(absl::IsNotFound(client_->PutAnchor(anchor).status()));
  pipeline_.anchors.clear();
  pipeline_.anchored = 5;
  const auto put = client_->PutAnchor(anchor);
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_EQ(put->revision, 5);
  EXPECT_EQ(put->submap, anchor.submap);
  const auto anchors = client_->ListAnchors();
  ASSERT_TRUE(anchors.ok()) << anchors.status();
  ASSERT_EQ(anchors->size(), 1u);
  EXPECT_EQ(anchors->at(0).robot, RobotId("alice"));
  const Anchor& read = anchors->at(0).anchor;
  EXPECT_EQ(read.submap, anchor.submap);
  ExpectEqual(read.T_map_submap, kPose);
  EXPECT_EQ(read.sigma_xy_m, 0.1);
  EXPECT_EQ(read.sigma_z_m, 0.2);
  EXPECT_EQ(read.sigma_deg, 3);
  EXPECT_EQ(read.note, "total station");
  EXPECT_EQ(*client_->RemoveAnchor(anchor.submap), 5);
  EXPECT_THAT(pipeline_.unanchored, ElementsAre(anchor.submap));
}

TEST_F(ClientGraphTest, ARobotsNewestSubmapIsAnchored) {
  const SessionId session = client_->CreateSession("alice", "vlp16")->record.id;
  pipeline_.anchored = 5;
  Anchor anchor;
  anchor.sigma_xy_m = 2;
  Submap submap;
  submap.id = {session, 4};
  submap.robot = RobotId("alice");
  submap.keyframes.resize(1);
  ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
  const auto put = client_->PutAnchor(anchor, RobotId("alice"));
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_EQ(put->submap, submap.id);
  EXPECT_TRUE(absl::IsInvalidArgument(client_->PutAnchor(anchor).status())) << "nobody is named";
}

TEST_F(ClientGraphTest, ThePoseGraphBecomesAFile) {
  pipeline_.info.revision = 4;
  pipeline_.pose_graph = std::string(2'500'000, 'v') + "end";
  const std::string path = testing::TempDir() + "/client_graph_test.g2o";
  const auto summary = client_->ExportPoseGraphToFile(0, path);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->revision, 4);
  EXPECT_EQ(summary->size, pipeline_.pose_graph.size());
  std::ifstream file(path, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), pipeline_.pose_graph);
  const std::string none = testing::TempDir() + "/client_graph_test_none.g2o";
  EXPECT_TRUE(absl::IsNotFound(client_->ExportPoseGraphToFile(3, none).status()));
  EXPECT_FALSE(std::ifstream(none).good());
}

}  // namespace
}  // namespace isthmus::client
