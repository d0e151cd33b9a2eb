#include "server/pose_graph/own_scale.h"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_GT(scaled->sigma_scale, 5);
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
