#include "server/pose_graph/own_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "server/pose_graph/limits.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

constexpr int kSide = 12;

// Measured with `noise` times the sigma that the information says, and `wrong` links between
// places that have nothing to do with each other, at the end.
Problem DoubtedGrid(uint64_t seed, double noise, int wrong) {
  const std::vector<Pose> truth = Grid(kSide, kSide);
  GraphMaker maker(seed);
  Problem problem;
  const EdgeNoise said{0.02, 0.002};
  const EdgeNoise real{noise * said.position_m, noise * said.rotation_rad};
  AddOdometry(truth, real, &maker, &problem);
  AddRowLinks(truth, kSide, kSide, real, &maker, &problem);
  for (int i = 0; i < wrong; ++i) {
    Edge edge = maker.Measure(truth, i, 140 - 2 * i, real);
    edge.T_a_b = maker.RandomPose(20, 3);
    problem.edges.push_back(edge);
  }
  for (Edge& edge : problem.edges) {
    edge.information = said.Information();
    edge.may_be_wrong = std::abs(edge.a - edge.b) != 1;
  }
  return problem;
}

// Right and wrong ones that were discarded.
std::pair<int, int> Discarded(const Problem& problem, const Result& result, int wrong) {
  const size_t first_wrong = problem.edges.size() - static_cast<size_t>(wrong);
  std::pair<int, int> discarded;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    if (result.edge_weights[i] >= 0.5) continue;
    ++(i < first_wrong ? discarded.first : discarded.second);
  }
  return discarded;
}

// Four robots that stroll about one square, and links between places less than 3 m apart, with
// `noise` times the sigma that the information says; then `wrong` ones.
Problem DoubtedTeam(uint64_t seed, double noise, int wrong) {
  constexpr int kRobots = 4, kSteps = 150, kLinks = 240;
  const EdgeNoise said{0.05, 0.01}, real{noise * said.position_m, noise * said.rotation_rad};
  GraphMaker maker(seed);
  std::normal_distribution<double> normal;
  std::vector<Pose> truth;
  for (int robot = 0; robot < kRobots; ++robot) {
    Eigen::Vector2d at(2.0 * robot, -3.0 * robot);
    double yaw = 1.6 * robot;
    for (int i = 0; i < kSteps; ++i) {
      truth.push_back(Pose::FromXyzRpy(at.x(), at.y(), 0, 0, 0, yaw));
      const double home = std::atan2(-at.y(), -at.x());
      yaw += 0.15 * normal(maker.random());
      if (at.norm() > 20) yaw += 0.3 * std::remainder(home - yaw, 2 * std::numbers::pi);
      at += Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    }
  }
  Problem problem;
  AddOdometry(truth, said, &maker, &problem);
  std::uniform_int_distribution<int> any(0, kRobots * kSteps - 1);
  for (int links = 0; links < kLinks;) {
    const int a = any(maker.random()), b = any(maker.random());
    if (std::abs(a - b) < 50 || (truth[a].translation() - truth[b].translation()).norm() > 3) {
      continue;
    }
    problem.edges.push_back(maker.Measure(truth, a, b, real));
    ++links;
  }
  for (int i = 0; i < wrong; ++i) {
    Edge edge = maker.Measure(truth, i, kRobots * kSteps - 1 - 2 * i, real);
    edge.T_a_b = maker.RandomPose(3, 3);
    problem.edges.push_back(edge);
  }
  for (Edge& edge : problem.edges) {
    edge.information = said.Information();
    edge.may_be_wrong = std::abs(edge.a - edge.b) != 1;
  }
  return problem;
}

TEST(OwnScale, QuartileOfHonestErrorsIsOne) {
  EXPECT_EQ(VarianceScale({}), 0);
  EXPECT_NEAR(VarianceScale({100, 1e9, 50, 2e9}), 100 / 3.45, 1e-9);
  EXPECT_NEAR(VarianceScale({1e9, 3.45, 5, 2}), 1, 1e-9);
}

TEST(OwnScale, HonestSigmasAreBelieved) {
  const Problem problem = DoubtedGrid(1, 1, 10);
  const auto scaled = OptimizeAtOwnScale(problem, {});
  ASSERT_TRUE(scaled.ok()) << scaled.status();
  const auto [right, wrong] = Discarded(problem, scaled->result, 10);
  EXPECT_LE(right, 2);
  EXPECT_EQ(wrong, 10);
  EXPECT_LT(scaled->sigma_scale, 2.5);
}

TEST(OwnScale, SigmasFiveTimesTooSmallCostNoRightEdge) {
  const Problem problem = DoubtedGrid(2, 5, 10);
  const auto believed = Optimize(problem);
  ASSERT_TRUE(believed.ok());
  EXPECT_GT(Discarded(problem, *believed, 10).first, 40) << "what --robust did to public graphs";
  const auto scaled = OptimizeAtOwnScale(problem, {});
  ASSERT_TRUE(scaled.ok()) << scaled.status();
  const auto [right, wrong] = Discarded(problem, scaled->result, 10);
  EXPECT_LE(right, 2);
  EXPECT_EQ(wrong, 10);
  EXPECT_GE(scaled->sigma_scale, 4);
}

// Loops that are three times worse than odometry bend it, and so look better than they are: a scale
// that is told by what agrees already leaves half of them out.
TEST(OwnScale, LoopsThatAreWorseThanOdometryAreKept) {
  for (const uint64_t seed : {11, 12, 13}) {
    for (const int wrong : {0, 60}) {
      const Problem problem = DoubtedTeam(seed, 3, wrong);
      const auto scaled = OptimizeAtOwnScale(problem, {});
      ASSERT_TRUE(scaled.ok()) << scaled.status();
      const auto [right, false_ones] = Discarded(problem, scaled->result, wrong);
      EXPECT_LE(right, 7) << "of 240; seed " << seed << ", wrong " << wrong;
      EXPECT_GE(false_ones, 0.98 * wrong) << "seed " << seed;
    }
  }
}

TEST(OwnScale, FewEdgesTellNoScale) {
  const std::vector<Pose> truth = Ring(30, 10);
  GraphMaker maker(5);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem);
  Edge wrong = maker.Measure(truth, 0, 15, {});
  wrong.T_a_b = Pose();
  wrong.may_be_wrong = true;
  problem.edges.push_back(wrong);
  const auto scaled = OptimizeAtOwnScale(problem, {});
  ASSERT_TRUE(scaled.ok()) << scaled.status();
  EXPECT_EQ(scaled->sigma_scale, 1);
  EXPECT_EQ(scaled->result.edge_weights.back(), 0);
}

}  // namespace
}  // namespace isthmus::pose_graph
