#include "client/console/pose_graph_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string Write(const std::string& text) {
  const std::string path = ScratchFolder() + "/graph.g2o";
  std::ofstream(path) << text;
  return path;
}

constexpr char kVertices[] =
    "VERTEX_SE3:QUAT 7 1 2 3 0 0 0 1\n"
    "VERTEX_SE3:QUAT 9 4 5 6 0 0 0 1\n";

TEST(PoseGraphFile, KeepsWhatItsVerticesAreCalled) {
  const std::string path =
      Write(std::string("# of today\n# VERTEX 9 alice-1/12\n#VERTEX is no name\n") + kVertices);
  const auto file = ReadPoseGraph(path);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(file->names.size(), 1u);
  EXPECT_EQ(file->names.at(9), (SubmapId{SessionId("alice-1"), 12}));
  ASSERT_EQ(file->graph.problem.poses.size(), 2u);
  const std::string copy = ScratchFolder() + "/copy.g2o";
  ASSERT_TRUE(WritePoseGraph(copy, *file).ok());
  const auto again = ReadPoseGraph(copy);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->names, file->names);
  EXPECT_EQ(again->graph.ids, file->graph.ids);
  EXPECT_EQ(again->graph.problem.poses[1].translation(), Eigen::Vector3d(4, 5, 6));
}

TEST(PoseGraphFile, NamesThatAreNoneAreRefused) {
  for (const char* name :
       {"# VERTEX 9 alice-1\n", "# VERTEX alice-1/3\n", "# VERTEX 9 alice-1/x\n", "# VERTEX 9 /3\n",
        "# VERTEX 9 alice-1/-3\n", "# VERTEX 9 alice-1/3\n# VERTEX 9 alice-1/4\n"}) {
    const std::string path = Write(std::string(name) + kVertices);
    const auto file = ReadPoseGraph(path);
    EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << name;
    EXPECT_THAT(std::string(file.status().message()), HasSubstr(path));
  }
}

TEST(PoseGraphFile, WhatIsNoPoseGraphNamesTheFile) {
  EXPECT_TRUE(absl::IsNotFound(ReadPoseGraph("/no/such.g2o").status()));
  const std::string path = Write("VERTEX_SE3:QUAT 7 1 2\n");
  const auto file = ReadPoseGraph(path);
  EXPECT_TRUE(absl::IsInvalidArgument(file.status()));
  EXPECT_THAT(std::string(file.status().message()), HasSubstr(path));
}

TEST(SubmapName, IsSessionAndIndex) {
  EXPECT_EQ(*ParseSubmapId("alice-1/7"), (SubmapId{SessionId("alice-1"), 7}));
  for (const char* text : {"", "alice-1", "/7", "alice-1/", "alice-1/7/8", "alice-1/7x"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseSubmapId(text).status())) << text;
  }
}

// Ten vertices in a row, 1 m apart, and an edge that says that the last lies on the first.
std::string RowWithAFalseLoop() {
  std::string text;
  const std::string tail = " 0 0 0 0 0 1 1e4 0 0 0 0 0 1e4 0 0 0 0 1e4 0 0 0 1e4 0 0 1e4 0 1e4\n";
  for (int i = 0; i < 10; ++i) {
    text += "VERTEX_SE3:QUAT " + std::to_string(i) + " " + std::to_string(i) + " 0 0 0 0 0 1\n";
  }
  for (int i = 0; i < 9; ++i) {
    text += "EDGE_SE3:QUAT " + std::to_string(i) + " " + std::to_string(i + 1) + " 1" + tail;
  }
  return text + "EDGE_SE3:QUAT 0 9 0" + tail;
}

double LengthOf(const std::string& path) {
  const auto file = ReadPoseGraph(path);
  EXPECT_TRUE(file.ok()) << file.status();
  const std::vector<Pose>& poses = file->graph.problem.poses;
  return (poses.back().translation() - poses.front().translation()).norm();
}

TEST(OptimizeCommand, DiscardsWhatTheRestContradictsIfAskedTo) {
  const std::string path = Write(RowWithAFalseLoop());
  const std::string out = path + ".out";
  const ProgramResult plain = Isthmus("optimize " + path + " " + out);
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_THAT(plain.out, HasSubstr("vertices: 10, edges: 10, discarded: 0"));
  EXPECT_THAT(plain.out, HasSubstr("chi2 810000 -> "));
  EXPECT_LT(LengthOf(out), 8) << "bent";
  const ProgramResult robust = Isthmus("optimize --robust --json " + path + " " + out);
  ASSERT_EQ(robust.code, 0) << robust.err;
  EXPECT_EQ(json::parse(robust.out)["discarded"], 1);
  EXPECT_NEAR(LengthOf(out), 9, 1e-6);
}

TEST(OptimizeCommand, SaysWhatItLeftOutAndComparesWithOthers) {
  std::string text = RowWithAFalseLoop() + "VERTEX_PLANE 77 0 0 1 0\n";
  text = text.substr(text.find("EDGE"));
  const std::string path = Write(text);
  const ProgramResult run = Isthmus("optimize --json " + path + " " + path + ".out");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("left out: 1 x VERTEX_PLANE"));
  EXPECT_THAT(run.err, HasSubstr("placed by their edges: 10"));
  const json summary = json::parse(run.out);
  EXPECT_EQ(summary["left_out"]["VERTEX_PLANE"], 1);
  EXPECT_EQ(summary["placed_by_edges"], 10);
  // Pure translations: g2o's error is ours.
  EXPECT_NEAR(summary["final_g2o_chi2"], summary["final_chi2"], 1e-3);
  EXPECT_NEAR(summary["initial_g2o_chi2"], 810000, 1e-3);
  EXPECT_THAT(Isthmus("optimize " + path + " " + path + ".out").out, HasSubstr("as g2o counts: "));
}

TEST(OptimizeCommand, FilesThatCannotBeUsedGiveFive) {
  EXPECT_EQ(Isthmus("optimize /no/such.g2o /dev/null").code, 5);
  EXPECT_EQ(Isthmus("optimize " + Write("no graph") + " /dev/null").code, 5);
  EXPECT_EQ(Isthmus("optimize " + Write(kVertices)).code, 2);
}

}  // namespace
}  // namespace isthmus::cli
