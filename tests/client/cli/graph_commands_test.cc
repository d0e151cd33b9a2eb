// The commands about revisions, loop closures, anchors and the pose graph: the built program, the
// real RPC layer, and behind it a pipeline that answers what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "client/console/pose_graph_file.h"
#include "tests/client/cli/program.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class GraphCommandsTest : public rpc::RpcTest {
 protected:
  ProgramResult Ask(const std::string& command) const {
    return Isthmus(command + " --server " + server_->address());
  }
  json AskJson(const std::string& command) const {
    const ProgramResult result = Ask(command + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
};

RevisionInfo Info(int64_t revision) {
  RevisionInfo info;
  info.revision = revision;
  info.stamp_ns = 1'772'359'451'000'000'000;  // 2026-03-01 10:04:11 UTC.
  info.cause = "loop closure 3 of alice-1";
  info.matches = {{SessionId("alice-1"), SessionId("bob-1")}};
  info.loops = {3};
  info.added = 1;
  info.moved = 31;
  info.largest_move_m = 0.4125;
  return info;
}

SubmapMove Move(uint32_t index, std::optional<Pose> before, std::optional<Pose> after) {
  SubmapMove move;
  move.submap = {SessionId("alice-1"), index};
  move.before = before;
  move.after = after;
  if (before) move.frame_before = SessionId("alice-1");
  if (after) move.frame_after = SessionId("alice-1");
  return move;
}

TEST_F(GraphCommandsTest, RevisionsAreATableOrJson) {
  pipeline_.revisions = std::vector<RevisionInfo>{Info(42)};
  const ProgramResult table = Ask("revisions --limit 7");
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_EQ(pipeline_.asked_limit, 7);
  EXPECT_THAT(table.out, HasSubstr("revision  time (UTC)"));
  EXPECT_THAT(table.out, HasSubstr("      42  2026-03-01 10:04:11      1    31       0      0.412 m"
                                   "  loop closure 3 of alice-1\n"));
  const json revisions = AskJson("revisions")["revisions"];
  ASSERT_EQ(revisions.size(), 1u);
  EXPECT_EQ(revisions[0]["revision"], 42);
  EXPECT_EQ(revisions[0]["stamp_ns"], 1'772'359'451'000'000'000);
  EXPECT_EQ(revisions[0]["matches"][0]["session_b"], "bob-1");
  EXPECT_EQ(revisions[0]["loops"], json({3}));
  EXPECT_EQ(revisions[0]["largest_move_m"], 0.4125);
}

// No terminal obeys what a server says, and no line of ours can be forged by it.
TEST_F(GraphCommandsTest, WhatOthersWroteIsEscapedEverywhere) {
  const std::string odd = "a\x1b[2Jb\nisthmus: forged\xc2\x9b";
  const std::string shown = "a\\x1b[2Jb\\x0aisthmus: forged\\xc2\\x9b";
  RevisionInfo revision = Info(42);
  revision.cause = odd;
  pipeline_.revisions = std::vector<RevisionInfo>{revision};
  RevisionDiff diff{41, 42, {Move(0, {}, Pose())}, {revision}};
  diff.moves[0].frame_after = SessionId(odd);
  pipeline_.diff = diff;
  Anchor anchor;
  anchor.submap = {SessionId("alice-1"), 0};
  anchor.note = odd;
  pipeline_.anchors = {anchor};
  MatchEdge match;
  match.match.a = SessionId(odd);
  match.match.b = SessionId("bob-1");
  match.match.detail = odd;
  pipeline_.graph.matches = {match};
  pipeline_.graph.placements = {{{SessionId(odd), 0, SessionId(odd), Pose()}, RobotId(odd)}};
  Loop loop;
  loop.loop.session = SessionId(odd);
  pipeline_.loops = std::vector<Loop>{loop};
  MapInfo info;
  info.damaged = {odd};
  info.storage_problem = odd;
  info.components.resize(1);
  info.components[0].robots = {RobotId(odd)};
  info.components[0].reference = SessionId(odd);
  pipeline_.info = info;
  for (const char* command :
       {"revisions", "revisions diff 41", "anchor list", "graph", "loops", "status"}) {
    const ProgramResult text = Ask(command);
    EXPECT_EQ(text.code, 0) << command << text.err;
    EXPECT_THAT(text.out, HasSubstr(shown)) << command;
    for (const std::string& all : {text.out, text.err, Ask(std::string(command) + " --json").out}) {
      EXPECT_EQ(all.find_first_of("\x1b\xc2\x9b"), std::string::npos) << command << all;
      EXPECT_EQ(all.find("\nisthmus: forged"), std::string::npos) << command << all;
    }
  }
}

TEST_F(GraphCommandsTest, ADifferenceSaysWhatBecameOfEverySubmap) {
  RevisionDiff diff;
  diff.from = 41;
  diff.to = 42;
  diff.revisions = {Info(42)};
  const Pose there(Eigen::Vector3d(3, 4, 0));
  diff.moves = {Move(0, Pose(), there), Move(1, {}, there), Move(2, there, {}),
                Move(3, Pose(), there)};
  diff.moves[3].frame_after = SessionId("bob-1");
  pipeline_.diff = diff;
  const ProgramResult text = Ask("revisions diff 41");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_EQ(pipeline_.asked_diff, std::make_pair(int64_t{41}, int64_t{0})) << "0 is the latest";
  EXPECT_THAT(text.out, HasSubstr("revision 41 to 42: 4 submaps"));
  EXPECT_THAT(text.out, HasSubstr("alice-1/0: moved by 5.000 m, 0.00 deg\n"));
  EXPECT_THAT(text.out, HasSubstr("alice-1/1: came, in the frame of alice-1: x 3.000"));
  EXPECT_THAT(text.out, HasSubstr("alice-1/2: went"));
  EXPECT_THAT(text.out, HasSubstr("alice-1/3: from the frame of alice-1 to that of bob-1"));
  EXPECT_THAT(text.out, HasSubstr("loop closure 3 of alice-1"));
  const json read = AskJson("revisions diff 41 42");
  EXPECT_EQ(pipeline_.asked_diff, std::make_pair(int64_t{41}, int64_t{42}));
  EXPECT_EQ(read["from_revision"], 41);
  EXPECT_EQ(read["revisions"][0]["revision"], 42);
  EXPECT_EQ(read["moves"][0]["move_m"], 5);
  EXPECT_FALSE(read["moves"][1].contains("before"));
  EXPECT_EQ(read["moves"][1]["after"]["translation"]["y"], 4);
  EXPECT_FALSE(read["moves"][2].contains("after"));
  EXPECT_FALSE(read["moves"][3].contains("move_m")) << "another frame";
  EXPECT_EQ(read["moves"][3]["reference_after"], "bob-1");
}

TEST_F(GraphCommandsTest, RevisionsThatAreNotThereGiveSix) {
  EXPECT_EQ(Ask("revisions diff 3 99").code, 6);
  EXPECT_EQ(Ask("revisions undo 99").code, 6);
  pipeline_.diff = absl::OutOfRangeError("the oldest that is kept is 7");
  const ProgramResult old = Ask("revisions diff 3");
  EXPECT_EQ(old.code, 6);
  EXPECT_THAT(old.err, HasSubstr("the oldest that is kept is 7"));
  EXPECT_EQ(Ask("revisions diff -3").code, 2);
  EXPECT_EQ(Ask("revisions diff").code, 2);
  EXPECT_EQ(Ask("revisions --limit 0").code, 2);
}

TEST_F(GraphCommandsTest, ARevisionIsUndoneWithANote) {
  pipeline_.undo = 43;
  const ProgramResult undo = Ask("revisions undo 42 --note 'the twin stairwell'");
  ASSERT_EQ(undo.code, 0) << undo.err;
  EXPECT_THAT(undo.out, HasSubstr("revision 42 is undone: the map is at revision 43"));
  ASSERT_EQ(pipeline_.undone.size(), 1u);
  EXPECT_EQ(pipeline_.undone[0].first, 42);
  EXPECT_EQ(pipeline_.undone[0].second, "the twin stairwell");
  EXPECT_EQ(AskJson("revisions undo 42")["revision"], 43);
  pipeline_.undo = absl::FailedPreconditionError("new submaps made it");
  const ProgramResult none = Ask("revisions undo 42");
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("new submaps"));
}

Loop SomeLoop(uint64_t id, uint32_t used) {
  Loop status;
  status.loop.id = id;
  status.loop.session = SessionId("alice-1");
  status.loop.submap_a = 2;
  status.loop.submap_b = 40;
  status.loop.confidence = 0.75;
  status.loop.overlap = 0.5;
  status.loop.detail = "half of it lies on it";
  status.loop.edges.resize(3);
  status.edge_count = 3;
  status.edges_used = used;
  return status;
}

TEST_F(GraphCommandsTest, LoopsAreATableThatSaysWhatCounts) {
  std::vector<Loop> loops = {SomeLoop(17, 2), SomeLoop(18, 0), SomeLoop(19, 0)};
  loops[2].loop.rejected = true;
  loops[2].loop.note = "another floor";
  pipeline_.loops = loops;
  const ProgramResult table = Ask("loops alice");
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_EQ(pipeline_.asked_robot, RobotId("alice"));
  EXPECT_THAT(table.out, HasSubstr("    17  alice-1          2 ~ 40       USED "));
  EXPECT_THAT(table.out, HasSubstr("2/3  half of it lies on it\n"));
  EXPECT_THAT(table.out, HasSubstr("    18  alice-1          2 ~ 40       SET ASIDE "));
  EXPECT_THAT(table.out, HasSubstr("    19  alice-1          2 ~ 40       REJECTED "));
  EXPECT_THAT(table.out, HasSubstr("\"another floor\""));
  const json read = AskJson("loops")["loops"];
  EXPECT_FALSE(pipeline_.asked_robot.has_value());
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[0]["id"], 17);
  EXPECT_EQ(read[0]["overlap"], 0.5);
  EXPECT_EQ(read[0]["free_space"], -1) << "not computed";
  EXPECT_EQ(read[0]["edges_used"], 2);
  EXPECT_EQ(read[0]["edge_count"], 3);
  EXPECT_TRUE(read[0]["edges"].empty());
  EXPECT_EQ(read[2]["rejected"], true);
  EXPECT_EQ(AskJson("loops --edges")["loops"][0]["edges"].size(), 3u);
  pipeline_.loops = absl::NotFoundError("no robot \"carol\"");
  EXPECT_EQ(Ask("loops carol").code, 6);
}

TEST_F(GraphCommandsTest, APersonsDecisionOnALoop) {
  Loop decided = SomeLoop(17, 0);
  decided.loop.rejected = true;
  pipeline_.decided_loop = DecidedLoop{.revision = 8, .loop = decided};
  const ProgramResult reject = Ask("loops reject 17 --note 'another floor'");
  ASSERT_EQ(reject.code, 0) << reject.err;
  EXPECT_THAT(reject.out, HasSubstr("REJECTED"));
  EXPECT_EQ(AskJson("loops restore 17")["id"], 17);
  ASSERT_EQ(pipeline_.loop_decisions.size(), 2u);
  EXPECT_EQ(pipeline_.loop_decisions[0].id, 17u);
  EXPECT_TRUE(pipeline_.loop_decisions[0].rejected);
  EXPECT_EQ(pipeline_.loop_decisions[0].note, "another floor");
  EXPECT_FALSE(pipeline_.loop_decisions[1].rejected);
  pipeline_.decided_loop = absl::NotFoundError("no loop closure 9");
  EXPECT_EQ(Ask("loops reject 9").code, 6);
  EXPECT_EQ(Ask("loops reject alice").code, 2);
  EXPECT_EQ(Ask("loops alice reject 17").code, 2);
  EXPECT_EQ(pipeline_.loop_decisions.size(), 3u);
}

TEST_F(GraphCommandsTest, AnAnchorHasOnlyWhatIsKnown) {
  pipeline_.anchored = 5;
  const ProgramResult set =
      Ask("anchor set alice-1/7 --position 12 -3.5 2 --rpy-deg 0 0 90 --sigma-xy 0.1 --sigma-z 0.2 "
          "--sigma-deg 3 --note 'total station'");
  ASSERT_EQ(set.code, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("alice-1/7 is anchored: the map is at revision 5"));
  EXPECT_EQ(AskJson("anchor set alice-1/8 --position 1 2 3 --sigma-xy 0.5")["index"], 8);
  ASSERT_EQ(pipeline_.anchors.size(), 2u);
  const Anchor& full = pipeline_.anchors[0];
  EXPECT_EQ(full.submap, (SubmapId{SessionId("alice-1"), 7}));
  EXPECT_EQ(full.T_map_submap.translation(), Eigen::Vector3d(12, -3.5, 2));
  EXPECT_NEAR(full.T_map_submap.Yaw(), std::acos(0.0), 1e-12) << "degrees";
  EXPECT_EQ(full.sigma_xy_m, 0.1);
  EXPECT_EQ(full.sigma_z_m, 0.2);
  EXPECT_EQ(full.sigma_deg, 3);
  EXPECT_EQ(full.note, "total station");
  EXPECT_EQ(pipeline_.anchors[1].sigma_z_m, 0) << "not known";
  EXPECT_EQ(pipeline_.anchors[1].sigma_deg, 0);
  const ProgramResult list = Ask("anchor list");
  EXPECT_THAT(list.out, AllOf(HasSubstr("alice-1/7"), HasSubstr("total station"), HasSubstr("free"),
                              HasSubstr("x 12.000 y -3.500 z 2.000 m")));
  const json anchors = AskJson("anchor list")["anchors"];
  ASSERT_EQ(anchors.size(), 2u);
  EXPECT_EQ(anchors[0]["index"], 7);
  EXPECT_EQ(anchors[1]["t_map_submap"]["translation"], json({{"x", 1}, {"y", 2}, {"z", 3}}));
  EXPECT_THAT(Ask("anchor remove alice-1/7").out, HasSubstr("no longer anchored"));
  EXPECT_EQ(pipeline_.unanchored.back(), (SubmapId{SessionId("alice-1"), 7}));
}

TEST_F(GraphCommandsTest, ARobotMeansItsNewestSubmap) {
  pipeline_.anchored = 5;
  SessionRequest request;
  request.robot = RobotId("alice");
  const auto session = pipeline_.sessions().Create(request);
  ASSERT_TRUE(session.ok());
  const std::string set = "anchor set alice --position 1 2 3 --sigma-xy 0.5";
  EXPECT_EQ(Ask(set).code, 6) << "the fake knows robots by their submaps";
  Submap submap;
  submap.id = {session->record.id, 4};
  submap.robot = RobotId("alice");
  submap.keyframes.resize(1);
  ASSERT_TRUE(pipeline_.sessions().AddSubmap(submap).ok());
  const ProgramResult result = Ask(set);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr(session->record.id.value() + "/4 is anchored"));
}

TEST_F(GraphCommandsTest, AnchorsThatMakeNoSenseGiveTwo) {
  const std::string set = "anchor set alice-1/7 --position 1 2 3 ";
  for (const std::string& command :
       {set, set + "--sigma-xy 0", set + "--sigma-xy -1", set + "--sigma-xy 1 --rpy-deg 0 0 90",
        set + "--sigma-xy 1 --sigma-deg 3", std::string("anchor set alice-1/7 --sigma-xy 1"),
        std::string("anchor set alice-1/x --position 1 2 3 --sigma-xy 1"),
        std::string("anchor remove alice"), std::string("anchor")}) {
    EXPECT_EQ(Ask(command).code, 2) << command;
  }
  EXPECT_TRUE(pipeline_.anchors.empty());
  EXPECT_EQ(Ask(set + "--sigma-xy 1").code, 6) << "no such submap";
}

// Odometry says 1 m twice, a loop says 1.9 m in all.
constexpr char kGraph[] =
    "# VERTEX 0 alice-1/0\n"
    "# VERTEX 1 alice-1/3\n"
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\n"
    "FIX 0\n"
    "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"
    "EDGE_SE3:QUAT 1 2 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"
    "EDGE_SE3:QUAT 0 2 1.9 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

TEST_F(GraphCommandsTest, AGraphIsExportedOptimizedAndPutAsAnchors) {
  pipeline_.pose_graph = kGraph;
  pipeline_.anchored = 5;
  const std::string folder = ScratchFolder();
  const std::string graph = folder + "/site.g2o", better = folder + "/better.g2o";
  const ProgramResult exported = Ask("graph --g2o " + graph);
  ASSERT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(exported.out, HasSubstr("pose graph of map 0"));
  EXPECT_EQ(Ask("graph --component 3 --g2o " + folder + "/none.g2o").code, 6);
  EXPECT_EQ(Ask("graph --component 3").code, 2) << "without --g2o";

  const ProgramResult optimized = Isthmus("optimize " + graph + " " + better + " --json");
  ASSERT_EQ(optimized.code, 0) << optimized.err;
  const json summary = json::parse(optimized.out);
  EXPECT_EQ(summary["vertices"], 3);
  EXPECT_EQ(summary["edges"], 3);
  EXPECT_EQ(summary["discarded"], 0);
  EXPECT_NEAR(summary["initial_chi2"].get<double>(), 0.01, 1e-9);
  EXPECT_NEAR(summary["final_chi2"].get<double>(), 0.01 / 3, 1e-9);
  EXPECT_EQ(summary["converged"], true);

  const ProgramResult imported =
      Ask("anchor import " + better + " --sigma-xy 0.05 --sigma-deg 0.2 --note g2o");
  ASSERT_EQ(imported.code, 0) << imported.err;
  EXPECT_THAT(imported.out, HasSubstr("2 submaps are anchored, 0 are not in the map"));
  ASSERT_EQ(pipeline_.anchors.size(), 2u) << "vertex 2 has no name";
  EXPECT_EQ(pipeline_.anchors[1].submap, (SubmapId{SessionId("alice-1"), 3}));
  EXPECT_NEAR(pipeline_.anchors[1].T_map_submap.translation().x(), 1 - 0.1 / 3, 1e-6);
  EXPECT_EQ(pipeline_.anchors[1].sigma_xy_m, 0.05);
  EXPECT_EQ(pipeline_.anchors[1].sigma_z_m, 0);
  EXPECT_EQ(pipeline_.anchors[1].sigma_deg, 0.2);
  EXPECT_EQ(pipeline_.anchors[1].note, "g2o");
}

TEST_F(GraphCommandsTest, WhatIsNotInTheMapIsNamedAndLeftOut) {
  const std::string path = ScratchFolder() + "/site.g2o";
  std::ofstream(path) << kGraph;
  const ProgramResult none = Ask("anchor import " + path + " --sigma-xy 0.05");
  EXPECT_EQ(none.code, 6);
  EXPECT_THAT(none.err, AllOf(HasSubstr("left out alice-1/0"), HasSubstr("left out alice-1/3")));
  std::ofstream(path) << "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  const ProgramResult nameless = Ask("anchor import " + path + " --sigma-xy 0.05");
  EXPECT_EQ(nameless.code, 5);
  EXPECT_THAT(nameless.err, HasSubstr("isthmus graph --g2o"));
  EXPECT_EQ(Ask("anchor import /no/such.g2o --sigma-xy 0.05").code, 5);
}

TEST_F(GraphCommandsTest, StatusSumsUp) {
  pipeline_.info.revision = 42;
  pipeline_.info.settled = true;
  pipeline_.info.submaps = 31;
  pipeline_.info.retired = 6;
  pipeline_.info.placement_ms = 12.5;
  pipeline_.info.placements = 9;
  std::vector<Loop> loops = {SomeLoop(1, 2), SomeLoop(2, 0)};
  loops[1].loop.rejected = true;
  pipeline_.loops = loops;
  const ProgramResult text = Ask("status");
  EXPECT_THAT(text.out, HasSubstr("revision     42\n"));
  EXPECT_THAT(text.out, HasSubstr("submaps      31 in the map, 6 retired"));
  EXPECT_THAT(text.out, HasSubstr("loops        2 closed, 1 of them rejected"));
  EXPECT_THAT(text.out, HasSubstr("placement    12.5 ms the last of 9\n"));
  const json status = AskJson("status");
  EXPECT_EQ(status["submaps"], 31);
  EXPECT_EQ(status["retired"], 6);
  EXPECT_EQ(status["loops"], 2);
  EXPECT_EQ(status["loops_rejected"], 1);
  EXPECT_EQ(status["placement_ms"], 12.5);
  EXPECT_EQ(status["placements"], 9);
}

}  // namespace
}  // namespace isthmus::cli
