#include "server/pose_graph/gnc.h"

#include <gtest/gtest.h>

#include "core/geometry/se3.h"
#include "server/pose_graph/drift_gate.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

constexpr int kRows = 10, kColumns = 20;

// A grid with links between its rows, all of them in doubt.
Problem Links(const std::vector<Pose>& truth, uint64_t seed) {
  GraphMaker maker(seed);
  Problem problem;
  AddOdometry(truth, {0.05, 0.004}, &maker, &problem);
  const size_t odometry = problem.edges.size();
  AddRowLinks(truth, kRows, kColumns, {0.03, 0.003}, &maker, &problem);
  for (size_t i = odometry; i < problem.edges.size(); ++i) problem.edges[i].may_be_wrong = true;
  return problem;
}

// As many false links that `share` of all links are false: any two nodes, any transform of a few
// metres, as places that look alike give.
void AddFalseLinks(const std::vector<Pose>& truth, double share, uint64_t seed, Problem* problem) {
  GraphMaker maker(seed);
  const double links = static_cast<double>(problem->edges.size() + 1 - truth.size());
  std::uniform_int_distribution<int> node(0, static_cast<int>(truth.size()) - 1);
  for (int i = 0; i < static_cast<int>(links * share / (1 - share)); ++i) {
    const int a = node(maker.random()), b = node(maker.random());
    if (std::abs(a - b) < 5) continue;
    Edge edge = maker.Measure(truth, a, b, {0.03, 0.003});
    edge.T_a_b = maker.RandomPose(5, 0.2);
    edge.may_be_wrong = true;
    problem->edges.push_back(edge);
  }
}

TEST(GncWeight, TruncatesEverSharper) {
  for (const double mu : {1e-3, 0.1, 1.0, 100.0}) {
    EXPECT_EQ(GncWeight(0, 16, mu), 1);
    EXPECT_EQ(GncWeight(16 * mu / (mu + 1), 16, mu), 1);
    EXPECT_EQ(GncWeight(16 * (mu + 1) / mu + 1e-9, 16, mu), 0);
    EXPECT_GT(GncWeight(10, 16, mu), GncWeight(20, 16, mu));
    // Continuous at both ends.
    EXPECT_NEAR(GncWeight(16 * mu / (mu + 1) * (1 + 1e-9), 16, mu), 1, 1e-6);
    EXPECT_NEAR(GncWeight(16 * (mu + 1) / mu * (1 - 1e-9), 16, mu), 0, 1e-6);
  }
  EXPECT_EQ(GncWeight(15.9, 16, 1e6), 1);
  EXPECT_EQ(GncWeight(16.1, 16, 1e6), 0);
}

TEST(Gnc, KeepsHonestEdges) {
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  const Problem problem = Links(truth, 1);
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->converged);
  int discarded = 0;
  for (const double weight : result->edge_weights) discarded += weight < 0.5;
  EXPECT_LE(discarded, 6);  // 1 % of 171 on average.
}

TEST(ChiSquareWithDrift, TellsDriftFromContradiction) {
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  Problem problem = Links(truth, 1);
  const size_t honest = problem.edges.size();
  AddFalseLinks(truth, 0.3, 2, &problem);
  const std::vector<double> chi2 = ChiSquareWithDrift(problem);
  double largest = 0, mean = 0, least_false = 1e300;
  for (size_t i = truth.size() - 1; i < honest; ++i) {
    largest = std::max(largest, chi2[i]);
    mean += chi2[i] / static_cast<double>(honest + 1 - truth.size());
  }
  for (size_t i = honest; i < chi2.size(); ++i) least_false = std::min(least_false, chi2[i]);
  EXPECT_LT(largest, 40);
  EXPECT_GT(largest, 6);
  EXPECT_NEAR(mean, 6, 3);  // Degrees of freedom; links of one drive are not independent.
  EXPECT_GT(least_false, 40);
  for (size_t i = 0; i + 1 < truth.size(); ++i) EXPECT_EQ(chi2[i], 0);
}

class FalseLinks : public testing::TestWithParam<int> {};

TEST_P(FalseLinks, ThirtyPercentChangeTheMapLittle) {
  const uint64_t seed = static_cast<uint64_t>(GetParam());
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  const Problem clean = Links(truth, seed);
  Problem problem = clean;
  AddFalseLinks(truth, 0.3, seed + 100, &problem);
  ASSERT_GT(problem.edges.size(), clean.edges.size() + 50);
  const auto expected = Optimize(clean), result = Optimize(problem);
  ASSERT_TRUE(expected.ok() && result.ok()) << result.status();
  for (size_t i = clean.edges.size(); i < problem.edges.size(); ++i) {
    EXPECT_EQ(result->edge_weights[i], 0) << i;
  }
  int lost = 0;
  for (size_t i = 0; i < clean.edges.size(); ++i) lost += result->edge_weights[i] < 0.5;
  EXPECT_LE(lost, 6);
  EXPECT_LT(Rmse(result->poses, truth), 1.2 * Rmse(expected->poses, truth));

  Options gullible;
  gullible.judge = false;
  const auto ruined = Optimize(problem, gullible);
  ASSERT_TRUE(ruined.ok());
  EXPECT_GT(Rmse(ruined->poses, truth), 5 * Rmse(expected->poses, truth));
}

INSTANTIATE_TEST_SUITE_P(Seeds, FalseLinks, testing::Range(1, 9));

TEST(Gnc, NeverDiscardsWhatIsNotInDoubt) {
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  Problem problem = Links(truth, 6);
  AddFalseLinks(truth, 0.3, 7, &problem);
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    if (problem.edges[i].may_be_wrong) continue;
    EXPECT_EQ(result->edge_weights[i], 1);
  }
}

TEST(Gnc, DiscardsAFalseAnchor) {
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  Problem problem = Links(truth, 8);
  problem.fixed = {0};
  for (const int node : {40, 90, 150}) {
    problem.anchors.push_back(
        {node, truth[static_cast<size_t>(node)], 25 * Matrix6d::Identity(), true});
  }
  problem.anchors[1].T_map_node = Pose(Eigen::Vector3d(60, 60, 60)) * problem.anchors[1].T_map_node;
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->anchor_weights, (std::vector<double>{1, 0, 1}));
}

// Discarding its only tie leaves a part of the graph with no place: it stays finite and near.
TEST(Gnc, APartWithoutATieStaysNearItsStart) {
  GraphMaker maker(9);
  const std::vector<Pose> truth = Ring(10, 5);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  problem.edges.erase(problem.edges.begin() + 4);  // Nodes 5-9 hang on doubtful edges alone.
  for (const double x : {3.0, -3.0}) {
    Edge edge = maker.Measure(truth, 2, 7, {}, true);
    edge.T_a_b = edge.T_a_b * Pose(Eigen::Vector3d(x, 0, 0));
    edge.may_be_wrong = true;
    problem.edges.push_back(edge);
  }
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(LargestDistance(result->poses, truth), 4);
  EXPECT_LT(result->final_chi2, 17);
}

// A judgement that holds is taken over; one that does not changes nothing.
TEST(Gnc, GoesOnFromAJudgement) {
  const std::vector<Pose> truth = Grid(kRows, kColumns);
  Problem problem = Links(truth, 1);
  AddFalseLinks(truth, 0.3, 2, &problem);
  const auto first = Optimize(problem);
  ASSERT_TRUE(first.ok()) << first.status();
  Options options;
  options.go_on = true;
  const auto unjudged = Optimize(problem, options);
  ASSERT_TRUE(unjudged.ok()) << unjudged.status();
  EXPECT_EQ(unjudged->edge_weights, first->edge_weights);
  EXPECT_LT(LargestDistance(unjudged->poses, first->poses), 1e-6);
  for (size_t i = 0; i < problem.edges.size(); ++i)
    problem.edges[i].weight = first->edge_weights[i];
  const auto again = Optimize(problem, options);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->edge_weights, first->edge_weights);
  EXPECT_LT(LargestDistance(again->poses, first->poses), 1e-4);
  EXPECT_LE(again->iterations, first->iterations);
  // Right ones discarded.
  for (size_t i = truth.size() - 1; i < problem.edges.size(); i += 5) problem.edges[i].weight = 0;
  const auto corrected = Optimize(problem, options);
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  EXPECT_EQ(corrected->edge_weights, first->edge_weights);
}

}  // namespace
}  // namespace isthmus::pose_graph
