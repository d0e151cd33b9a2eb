// Revisions, loop closures and the pose graph, over a socket: requests arrive, answers come back.
#include "core/io/crc32c.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using testing::ElementsAre;

class GraphRpcTest : public RpcTest {
 protected:
  grpc::Status Diff(int64_t from, int64_t to, std::vector<v1::DiffRevisionsResponse>* responses) {
    v1::DiffRevisionsRequest request;
    request.set_from_revision(from);
    request.set_to_revision(to);
    const auto context = NewContext();
    auto reader = stubs_->map->DiffRevisions(context.get(), request);
    v1::DiffRevisionsResponse response;
    while (reader->Read(&response)) responses->push_back(response);
    return reader->Finish();
  }
};

RevisionInfo Info(int64_t revision) {
  RevisionInfo info;
  info.revision = revision;
  info.stamp_ns = 100 * revision;
  info.cause = "match alice-1 ~ bob-1 ACCEPTED";
  info.matches = {{SessionId("alice-1"), SessionId("bob-1")}};
  info.loops = {3, 5};
  info.added = 1;
  info.moved = 2;
  info.removed = 3;
  info.largest_move_m = 0.5;
  return info;
}

TEST_F(GraphRpcTest, RevisionsComeWithTheirCause) {
  pipeline_.revisions = std::vector<RevisionInfo>{Info(9), Info(8)};
  v1::ListRevisionsRequest request;
  request.set_limit(2);
  v1::ListRevisionsResponse response;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListRevisions(NewContext().get(), request), &response));
  EXPECT_EQ(pipeline_.asked_limit, 2);
  EXPECT_EQ(response.revision(), 9);
  ASSERT_EQ(response.revisions_size(), 2);
  const v1::Revision& first = response.revisions(0);
  EXPECT_EQ(first.revision(), 9);
  EXPECT_EQ(first.stamp_ns(), 900);
  EXPECT_EQ(first.cause(), "match alice-1 ~ bob-1 ACCEPTED");
  ASSERT_EQ(first.matches_size(), 1);
  EXPECT_EQ(first.matches(0).session_a(), "alice-1");
  EXPECT_EQ(first.matches(0).session_b(), "bob-1");
  EXPECT_THAT(first.loops(), ElementsAre(3, 5));
  EXPECT_EQ(first.added(), 1u);
  EXPECT_EQ(first.moved(), 2u);
  EXPECT_EQ(first.removed(), 3u);
  EXPECT_EQ(first.largest_move_m(), 0.5);
}

TEST_F(GraphRpcTest, TheNumberOfRevisionsIsBounded) {
  v1::ListRevisionsRequest request;
  v1::ListRevisionsResponse response;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListRevisions(NewContext().get(), request), &response));
  EXPECT_EQ(pipeline_.asked_limit, 100);
  EXPECT_EQ(response.revision(), 0) << "the empty map";
  request.set_limit(4'000'000'000u);
  EXPECT_GRPC_OK(Merged(stubs_->map->ListRevisions(NewContext().get(), request), &response));
  EXPECT_EQ(pipeline_.asked_limit, 10'000);
  pipeline_.revisions = absl::DataLossError("a revision is damaged");
  EXPECT_GRPC_ERROR(Merged(stubs_->map->ListRevisions(NewContext().get(), request), &response),
                    DATA_LOSS, "damaged");
}

TEST_F(GraphRpcTest, ALargeDifferenceComesInChunksInOrder) {
  RevisionDiff diff;
  diff.from = 4;
  diff.to = 9;
  diff.revisions = {Info(9)};
  constexpr uint32_t kMoves = 20'000;
  for (uint32_t i = 0; i < kMoves; ++i) {
    SubmapMove move;
    move.submap = {SessionId("alice-1"), i};
    if (i > 0) {
      move.before = Pose(Eigen::Vector3d(1, 0, 0));
      move.frame_before = SessionId("alice-1");
    }
    if (i < kMoves - 1) {
      move.after = Pose(Eigen::Vector3d(0, 2, 0));
      move.frame_after = SessionId("bob-1");
    }
    diff.moves.push_back(move);
  }
  pipeline_.diff = diff;
  std::vector<v1::DiffRevisionsResponse> responses;
  EXPECT_GRPC_OK(Diff(4, 0, &responses));
  EXPECT_EQ(pipeline_.asked_diff, std::make_pair(int64_t{4}, int64_t{0}));
  ASSERT_GT(responses.size(), 1u);
  EXPECT_EQ(responses[0].revisions_size(), 1);
  EXPECT_EQ(responses[1].revisions_size(), 0) << "told once";
  std::vector<v1::SubmapMove> moves;
  for (const auto& response : responses) {
    EXPECT_EQ(response.from_revision(), 4);
    EXPECT_EQ(response.to_revision(), 9);
    EXPECT_LT(response.ByteSizeLong(), 2u << 20);
    moves.insert(moves.end(), response.moves().begin(), response.moves().end());
  }
  ASSERT_EQ(moves.size(), kMoves);
  EXPECT_FALSE(moves[0].has_before()) << "it came";
  EXPECT_EQ(moves[0].reference_after(), "bob-1");
  EXPECT_EQ(moves[1].index(), 1u);
  EXPECT_EQ(moves[1].before().translation().x(), 1);
  EXPECT_EQ(moves[1].reference_before(), "alice-1");
  EXPECT_EQ(moves[1].after().translation().y(), 2);
  EXPECT_FALSE(moves[kMoves - 1].has_after()) << "it went";
  EXPECT_EQ(moves[kMoves - 1].reference_after(), "");
}

TEST_F(GraphRpcTest, WhereNothingMovedTheRevisionsAreNamed) {
  pipeline_.diff = RevisionDiff{3, 3, {}, {}};
  std::vector<v1::DiffRevisionsResponse> responses;
  EXPECT_GRPC_OK(Diff(3, 3, &responses));
  ASSERT_EQ(responses.size(), 1u);
  EXPECT_EQ(responses[0].to_revision(), 3);
}

TEST_F(GraphRpcTest, DifferencesThatCannotBeTold) {
  std::vector<v1::DiffRevisionsResponse> responses;
  EXPECT_GRPC_ERROR(Diff(-1, 3, &responses), INVALID_ARGUMENT, "counted from 0");
  EXPECT_GRPC_ERROR(Diff(1, -3, &responses), INVALID_ARGUMENT, "counted from 0");
  EXPECT_GRPC_ERROR(Diff(1, 99, &responses), NOT_FOUND, "revision");
  pipeline_.diff = absl::OutOfRangeError("the oldest that is kept is 7");
  EXPECT_GRPC_ERROR(Diff(1, 9, &responses), OUT_OF_RANGE, "7");
  EXPECT_TRUE(responses.empty());
}

TEST_F(GraphRpcTest, ARevisionIsUndone) {
  pipeline_.undo = 12;
  v1::UndoRevisionRequest request;
  request.set_revision(9);
  request.set_note("the twin stairwell");
  v1::UndoRevisionResponse response;
  EXPECT_GRPC_OK(stubs_->edits->UndoRevision(NewContext().get(), request, &response));
  EXPECT_EQ(response.revision(), 12);
  EXPECT_THAT(pipeline_.undone, ElementsAre(std::make_pair(int64_t{9}, "the twin stairwell")));
  request.set_note(std::string(1001, 'x'));
  EXPECT_GRPC_ERROR(stubs_->edits->UndoRevision(NewContext().get(), request, &response),
                    INVALID_ARGUMENT, "1001 characters");
  EXPECT_EQ(pipeline_.undone.size(), 1u);
  request.clear_note();
  pipeline_.undo = absl::FailedPreconditionError("new submaps made it");
  EXPECT_GRPC_ERROR(stubs_->edits->UndoRevision(NewContext().get(), request, &response),
                    FAILED_PRECONDITION, "new submaps");
}

Loop SomeLoop(const std::string& session) {
  Loop status;
  status.robot = RobotId("alice");
  LoopClosure& loop = status.loop;
  loop.id = 17;
  loop.session = SessionId(session);
  loop.submap_a = 2;
  loop.submap_b = 40;
  loop.T_a_b = Pose(Eigen::Vector3d(1, 2, 3));
  loop.confidence = 0.75;
  loop.overlap = 0.5;
  loop.residual_m = 0.03;
  loop.comparisons = 9000;
  loop.source = GuessSource::kPlaces;
  loop.detail = "half of it lies on it";
  loop.computed_ns = 77;
  loop.note = "why";
  loop.edges.resize(2);
  loop.edges[1].submap_a = 3;
  loop.edges[1].submap_b = 41;
  loop.edges[1].information(0, 5) = loop.edges[1].information(5, 0) = 9;
  status.edge_count = 2;
  status.edges_used = 1;
  return status;
}

TEST_F(GraphRpcTest, LoopsOfAllRobotsOrOne) {
  const std::string session = stubs_->NewSession("alice");
  pipeline_.info.revision = 6;
  pipeline_.loops = std::vector<Loop>{SomeLoop(session)};
  v1::ListLoopsRequest request;
  v1::ListLoopsResponse response;
  EXPECT_GRPC_OK(Merged(stubs_->map->ListLoops(NewContext().get(), request), &response));
  EXPECT_FALSE(pipeline_.asked_robot.has_value());
  EXPECT_EQ(response.revision(), 6);
  ASSERT_EQ(response.loops_size(), 1);
  const v1::Loop& loop = response.loops(0);
  EXPECT_EQ(loop.id(), 17u);
  EXPECT_EQ(loop.session(), session);
  EXPECT_EQ(loop.robot(), "alice");
  EXPECT_EQ(loop.submap_a(), 2u);
  EXPECT_EQ(loop.submap_b(), 40u);
  EXPECT_EQ(loop.t_a_b().translation().z(), 3);
  EXPECT_EQ(loop.confidence(), 0.75);
  EXPECT_EQ(loop.overlap(), 0.5);
  EXPECT_EQ(loop.residual_m(), 0.03);
  EXPECT_EQ(loop.free_space(), -1) << "not computed";
  EXPECT_EQ(loop.comparisons(), 9000);
  EXPECT_EQ(loop.source(), v1::GUESS_SOURCE_PLACES);
  EXPECT_EQ(loop.detail(), "half of it lies on it");
  EXPECT_EQ(loop.computed_ns(), 77);
  EXPECT_FALSE(loop.rejected());
  EXPECT_EQ(loop.note(), "why");
  EXPECT_EQ(loop.edge_count(), 2u);
  EXPECT_EQ(loop.edges_used(), 1u);
  EXPECT_EQ(loop.edges_size(), 0) << "not asked for";
  request.set_robot("alice");
  request.set_include_edges(true);
  EXPECT_GRPC_OK(Merged(stubs_->map->ListLoops(NewContext().get(), request), &response));
  EXPECT_EQ(pipeline_.asked_robot, RobotId("alice"));
  ASSERT_EQ(response.loops(0).edges_size(), 2);
  EXPECT_EQ(response.loops(0).edges(1).submap_b(), 41u);
  EXPECT_EQ(response.loops(0).edges(1).information(5), 9);
  pipeline_.loops = absl::NotFoundError("no such robot");
  EXPECT_GRPC_ERROR(Merged(stubs_->map->ListLoops(NewContext().get(), request), &response),
                    NOT_FOUND, "robot");
}

TEST_F(GraphRpcTest, APersonsDecisionOnALoop) {
  Loop decided = SomeLoop("alice-1");
  decided.loop.rejected = true;
  pipeline_.decided_loop = DecidedLoop{11, decided};
  v1::DecideLoopRequest request;
  request.set_id(17);
  request.set_note("another floor");
  v1::DecideLoopResponse response;
  const auto decide = [&] {
    return stubs_->edits->DecideLoop(NewContext().get(), request, &response);
  };
  EXPECT_GRPC_ERROR(decide(), INVALID_ARGUMENT, "REJECT or RESTORE");
  request.set_decision(v1::DecideLoopRequest::REJECT);
  EXPECT_GRPC_OK(decide());
  EXPECT_EQ(response.revision(), 11);
  EXPECT_EQ(response.loop().id(), 17u);
  EXPECT_TRUE(response.loop().rejected());
  request.set_decision(v1::DecideLoopRequest::RESTORE);
  EXPECT_GRPC_OK(decide());
  request.set_note(std::string(1001, 'x'));
  EXPECT_GRPC_ERROR(decide(), INVALID_ARGUMENT, "1001 characters");
  ASSERT_EQ(pipeline_.loop_decisions.size(), 2u);
  EXPECT_EQ(pipeline_.loop_decisions[0].id, 17u);
  EXPECT_TRUE(pipeline_.loop_decisions[0].rejected);
  EXPECT_EQ(pipeline_.loop_decisions[0].note, "another floor");
  EXPECT_FALSE(pipeline_.loop_decisions[1].rejected);
  request.clear_note();
  pipeline_.decided_loop = absl::NotFoundError("no loop closure 17");
  EXPECT_GRPC_ERROR(decide(), NOT_FOUND, "17");
}

TEST_F(GraphRpcTest, ThePoseGraphComesInChunksWithItsChecksum) {
  pipeline_.info.revision = 4;
  pipeline_.pose_graph = std::string(2'500'000, 'v');
  v1::ExportPoseGraphRequest request;
  const auto context = NewContext();
  auto reader = stubs_->map->ExportPoseGraph(context.get(), request);
  v1::ExportPoseGraphResponse response;
  std::string file;
  int responses = 0;
  while (reader->Read(&response)) {
    ++responses;
    EXPECT_EQ(response.revision(), 4);
    file += response.data();
  }
  EXPECT_GRPC_OK(reader->Finish());
  EXPECT_EQ(responses, 4) << "three of data, one that sums up";
  EXPECT_EQ(file, pipeline_.pose_graph);
  EXPECT_TRUE(response.last());
  EXPECT_EQ(response.size(), file.size());
  EXPECT_EQ(response.crc32c(), io::Crc32c(file.data(), file.size()));
}

TEST_F(GraphRpcTest, APoseGraphOfNoComponent) {
  v1::ExportPoseGraphRequest request;
  request.set_component(3);
  const auto context = NewContext();
  auto reader = stubs_->map->ExportPoseGraph(context.get(), request);
  v1::ExportPoseGraphResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_GRPC_ERROR(reader->Finish(), NOT_FOUND, "component");
}

}  // namespace
}  // namespace isthmus::rpc
