#include "server/pose_graph/g2o.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
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
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0",        // Cut off.
      "VERTEX_SE3:QUAT 8 1 2 x 0 0 0 1",      // No number.
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0 0",      // No rotation.
      "VERTEX_SE3:QUAT 8 1 2 nan 0 0 0 1",    //
      "VERTEX_SE3:QUAT 8 1 2 1e999 0 0 0 1",  //
      "VERTEX_SE3:QUAT 8 1 2 3 0 0 0 1 5",    // Too much.
      "VERTEX_SE3:QUAT 7 1 2 3 0 0 0 1",      // Twice.
      "EDGE_SE3:QUAT 7 3" + pose,             // No information.
      "FIX",
      "FIX 7 x",
      "VERTEX_SE2 0 0 0",
      "EDGE_SE2 7 3 1 0 0 1 0 0 1 0",
      "EDGE_SE3:QUAT 7 3 x 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1",
      "\x7f\x45LF",
  };
  for (const std::string& line : third_lines) {
    const auto graph = Read(good + line + "\n");
    EXPECT_EQ(graph.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_NE(graph.status().message().find("line 3:"), std::string::npos) << graph.status();
  }
}

const char kTail[] = " 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

TEST(G2o, WhatIsNotNeededIsLeftOutAndCounted) {
  const std::string negative = " 1 0 0 0 0 0 1 -1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const std::string nan = " 1 0 0 0 0 0 1 nan 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const auto graph =
      Read(std::string(kVertices) + "VERTEX_PLANE 4 0 0 1 0\nVERTEX_TRACKXYZ 9 1 2 3\n" +
           "EDGE_SE3:QUAT 7 3" + kTail + "EDGE_SE3:QUAT 7 3" + negative + "EDGE_SE3:QUAT 3 7" +
           nan + "EDGE_SE3:QUAT 3 3" + kTail + "EDGE_SE3_PLANE 7 4 0 0 1 0 1 0 0 1 0 1\n" +
           "EDGE_SE3_PRIOR 7 0 0 0 0 0 0 0 1\nEDGE_SE3_PRIOR 3 0 0 0 0 0 0 0 1\nFIX 4 7\n");
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_EQ(graph->ids, (std::vector<int64_t>{3, 7}));
  EXPECT_EQ(graph->problem.edges.size(), 1u);
  EXPECT_EQ(graph->problem.fixed, std::vector<int>{1});
  EXPECT_EQ(graph->placed_by_edges, 0u);
  const std::map<std::string, size_t> expected = {
      {"EDGE_SE3_PLANE", 1},
      {"EDGE_SE3_PRIOR", 2},
      {"FIX of another vertex", 1},
      {"VERTEX_PLANE", 1},
      {"VERTEX_TRACKXYZ", 1},
      {"edge from a vertex to itself", 1},
      {"edge whose information is indefinite or not finite", 2}};
  EXPECT_EQ(graph->left_out, expected);
  EXPECT_TRUE(absl::IsInvalidArgument(Read("VERTEX_PLANE 4 0 0 1 0\n").status()));
}

// A false loop from 0 to 3 comes before the odometry that tells the right way.
TEST(G2o, VerticesThatLackArePlacedAlongOdometryFirst) {
  std::string text = std::string("EDGE_SE3:QUAT 0 3") + kTail;
  for (int i = 0; i < 4; ++i) {
    text += "EDGE_SE3:QUAT " + std::to_string(i) + " " + std::to_string(i + 1) + kTail;
  }
  const auto alone = Read(text);
  ASSERT_TRUE(alone.ok()) << alone.status();
  EXPECT_EQ(alone->placed_by_edges, 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(alone->problem.poses[static_cast<size_t>(i)].translation().x(), i, 1e-12);
  }
  const auto from_four = Read(text + "VERTEX_SE3:QUAT 4 10 5 0 0 0 0 1\n");
  ASSERT_TRUE(from_four.ok()) << from_four.status();
  EXPECT_EQ(from_four->placed_by_edges, 4u);
  EXPECT_LT((from_four->problem.poses[0].translation() - Eigen::Vector3d(6, 5, 0)).norm(), 1e-12);
}

TEST(G2o, PlanarGraphsStayInThePlaneAndAreWrittenAsTheyCame) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.1 1.5\nVERTEX_SE2 2 1 1 3\n"
      "EDGE_SE2 0 1 1 0 1.5707963 100 3 2 50 1 400\n"
      "EDGE_SE2 1 2 1 0 1.5707963 100 3 2 50 1 400\n"
      "EDGE_SE2 0 2 1.1 1 3.1 100 0 0 100 0 100\n";
  auto graph = Read(text);
  ASSERT_TRUE(graph.ok()) << graph.status();
  EXPECT_TRUE(graph->is_planar);
  // g2o's error of the second edge, written down anew: [x y angle] seen from the measured pose.
  const auto costs = CostsOfOthers(graph->problem, {0, 1, 0}, true);
  const double a = 1.5, m = 1.5707963;
  const double x = std::sin(a) * 0.9 - 1, y = std::cos(a) * 0.9;
  const Eigen::Vector3d e(std::cos(m) * x + std::sin(m) * y, -std::sin(m) * x + std::cos(m) * y,
                          3 - 1.5 - m);
  Eigen::Matrix3d information;
  information << 100, 3, 2, 3, 50, 1, 2, 1, 400;
  EXPECT_NEAR(costs.g2o, e.dot(information * e), 1e-9);
  const auto result = Optimize(graph->problem);
  ASSERT_TRUE(result.ok()) << result.status();
  for (const Pose& pose : result->poses) {
    EXPECT_LT(std::abs(pose.translation().z()), 1e-9);
    EXPECT_LT(pose.rotation().vec().head<2>().norm(), 1e-9);
  }
  std::stringstream file;
  ASSERT_TRUE(WriteG2o(graph->problem, graph->ids, file, true).ok());
  EXPECT_NE(file.str().find("VERTEX_SE2 1 1 0.1"), std::string::npos) << file.str();
  const auto again = ReadG2o(file);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->is_planar);
  EXPECT_LT((again->problem.edges[0].information - graph->problem.edges[0].information).norm(),
            1e-9);
}

// SE-Sync's weights written down anew, for an edge of known error: 0.1 rad about z, 0.2 m in x.
TEST(G2o, CostsOfOthersAreTheirs) {
  const auto graph = Read(
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
      "VERTEX_SE3:QUAT 1 0.2 0 0 0 0 0.04997916927067833 0.9987502603949663\n"
      "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 1 0 0 0 0 0 2 0 0 0 0 4 0 0 0 10 0 0 20 0 40\n");
  ASSERT_TRUE(graph.ok()) << graph.status();
  const auto costs = CostsOfOthers(graph->problem, {1}, false);
  EXPECT_NEAR(costs.g2o, 0.04 * 1 + 40 * std::pow(std::sin(0.05), 2), 1e-9);
  const double tau = 3 / (1 + 0.5 + 0.25), kappa = 3 / (2 * (0.1 + 0.05 + 0.025));
  EXPECT_NEAR(costs.se_sync, tau * 0.04 + kappa * 4 * (1 - std::cos(0.1)), 1e-9);
}

TEST(G2o, VerticesAloneAreReadWithoutTheRest) {
  std::istringstream text(std::string(kVertices) + "EDGE_SE3:QUAT 7 cut off\nvertex? no\n");
  const auto poses = ReadG2oVertices(text);
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[1].translation(), Eigen::Vector3d(1, 2, 3)) << "in order of ids";
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
