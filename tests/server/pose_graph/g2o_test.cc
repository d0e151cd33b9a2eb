#include "server/pose_graph/g2o.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "core/geometry/se3.h"
#include "server/pose_graph/optimize.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

absl::StatusOr<G2oGraph> Read(const std::string& text) {
  std::istringstream stream(text);
  return ReadG2o(stream);
}

const char kVertices[] =
    "VERTEX_SE3:QUAT 7 1 2 3 0 0 0 1\nVERTEX_SE3:QUAT 3 0 0 0 0 0 0.7071068 0.7071068\n";

Problem Sample() {
  const std::vector<Pose> truth = Ring(10, 5);
  GraphMaker maker(1);
  Problem problem;
  AddOdometry(truth, {0.1, 0.02}, &maker, &problem);
  problem.edges.push_back(maker.Measure(truth, 9, 0, {0.1, 0.02}));
  Matrix6d L = Matrix6d::Identity();
  L(5, 0) = 3;
  L(4, 1) = -2;
  for (Edge& edge : problem.edges) edge.information = 100 * L * L.transpose();
  problem.fixed = {4};
  return problem;
}

TEST(G2o, RoundTrip) {
  const Problem problem = Sample();
  std::stringstream file;
  ASSERT_TRUE(WriteG2o(problem, {}, file).ok());
  const auto graph = ReadG2o(file);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_LT(LargestDistance(graph->problem.poses, problem.poses), 1e-12);
  EXPECT_EQ(graph->problem.fixed, problem.fixed);
  ASSERT_EQ(graph->problem.edges.size(), problem.edges.size());
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    const Edge &read = graph->problem.edges[i], &written = problem.edges[i];
    EXPECT_EQ(read.a, written.a);
    EXPECT_EQ(read.b, written.b);
    EXPECT_LT(Log(read.T_a_b.Inverse() * written.T_a_b).norm(), 1e-12);
    EXPECT_LT((read.information - written.information).norm(), 1e-9 * written.information.norm());
  }
}

// g2o's own error, written down anew: chi2 of small errors is the same in both conventions.
TEST(G2o, InformationMeansTheSameInBothConventions) {
  GraphMaker maker(2);
  for (int i = 0; i < 20; ++i) {
    const Pose M = maker.RandomPose(10, 3);
    Matrix6d A;
    for (int k = 0; k < 6; ++k) A.col(k) = maker.RandomTwist(1, 1);
    const Matrix6d g2o = A * A.transpose();
    const Matrix6d ours = FromG2oInformation(g2o, M);
    EXPECT_LT((ToG2oInformation(ours, M) - g2o).norm(), 1e-9 * g2o.norm());
    const Pose measured = M * Exp(maker.RandomTwist(1e-5, 1e-5));
    const Pose gap = M.Inverse() * measured;
    Vector6d e;
    e << gap.translation(), gap.rotation().vec();
    const Vector6d twist = EdgeError(Pose(), measured, M);
    EXPECT_NEAR(twist.dot(ours * twist), e.dot(g2o * e), 1e-3 * e.dot(g2o * e));
  }
}

TEST(G2o, AnchorsBecomeEdgesFromAFixedVertex) {
  Problem problem = Sample();
  problem.fixed.clear();
  Anchor anchor{4, Pose::FromXyzRpy(9, 8, 7, 0.1, 0.2, 1), Matrix6d::Identity()};
  anchor.information(1, 1) = 50;
  problem.anchors = {anchor};
  std::stringstream file;
  ASSERT_TRUE(WriteG2o(problem, {}, file).ok());
  const auto graph = ReadG2o(file);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(graph->problem.fixed, std::vector<int>{10});
  const auto expected = Optimize(problem), result = Optimize(graph->problem);
  ASSERT_TRUE(expected.ok() && result.ok());
  std::vector<Pose> poses = result->poses;
  poses.pop_back();
  EXPECT_LT(LargestDistance(poses, expected->poses), 1e-4);
}

TEST(G2o, KeepsIdsAndTakesAnyOrder) {
  const auto graph = Read(
      "# a comment\n\nEDGE_SE3:QUAT 7 3 1 0 0 0 0 0 2 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 "
      "4 0 0 4 0 4\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n" +
      std::string(kVertices) + "FIX 7\r\n");
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(graph->ids, (std::vector<int64_t>{3, 7}));
  EXPECT_EQ(graph->problem.edges[0].a, 1);
  EXPECT_EQ(graph->problem.edges[0].b, 0);
  EXPECT_EQ(graph->problem.fixed, std::vector<int>{1});
  EXPECT_NEAR(graph->problem.poses[0].Yaw(), 1.5707963, 1e-6);
  // 4 of half turns is 1 of turns.
  EXPECT_NEAR(graph->problem.edges[0].information(3, 3), 1, 1e-9);
}

TEST(G2o, DamageIsToldByLine) {
  const std::string good = kVertices;
  const std::string pose = " 1 0 0 0 0 0 1 ";
  const std::vector<std::string> third_lines = {
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0",                                            // Cut off.
      "VERTEX_SE3:QUAT 8 1 2 x 0 0 0 1",                                          // No number.
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0 0",                                          // No rotation.
      "VERTEX_SE3:QUAT 8 1 2 nan 0 0 0 1",                                        //
      "VERTEX_SE3:QUAT 8 1 2 1e999 0 0 0 1",                                      //
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0 1 5",                                        // Too much.
      "VERTEX_SE3:QUAT 7 1 2 3 0 0 0 1",                                          // Twice.
      "EDGE_SE3:QUAT 7 3" + pose,                                                 // No information.
      "EDGE_SE3:QUAT 7 3" + pose + "-1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",  // Negative.
      "EDGE_SE3:QUAT 7 4" + pose + "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",   // No node 4.
      "EDGE_SE3:QUAT 7 7" + pose + "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",   // With itself.
      "FIX 9",
      "FIX",
      "FIX 7 x",
      "VERTEX_SE2 0 0 0 0",
      "EDGE_SE3_PRIOR 7 1",
      "\x7f\x45LF",
  };
  for (const std::string& line : third_lines) {
    const auto graph = Read(good + line + "\n");
    EXPECT_EQ(graph.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_NE(graph.status().message().find("line 3:"), std::string::npos) << graph.status();
  }
  EXPECT_NE(Read("VERTEX_SE2 0 0 0 0").status().message().find("planar"), std::string::npos);
}

TEST(G2o, AnyPrefixOfAFileIsReadOrRefused) {
  std::stringstream file;
  ASSERT_TRUE(WriteG2o(Sample(), {}, file).ok());
  const std::string text = file.str();
  for (size_t length = 0; length < text.size(); length += 37) {
    const auto graph = Read(text.substr(0, length));
    if (graph.ok()) continue;
    EXPECT_EQ(graph.status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(G2o, RefusesToWriteWhatHangsTogetherBadly) {
  std::ostringstream file;
  Problem problem = Sample();
  EXPECT_EQ(WriteG2o(problem, {1, 2}, file).code(), absl::StatusCode::kInvalidArgument);
  problem.edges[0].b = 10;
  EXPECT_EQ(WriteG2o(problem, {}, file).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isthmus::pose_graph
