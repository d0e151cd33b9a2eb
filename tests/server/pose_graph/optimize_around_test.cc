#include "server/pose_graph/optimize_around.h"

#include <gtest/gtest.h>

#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

constexpr int kLongRows = 30, kLongColumns = 20;

// An optimised grid of 600 nodes with a new link of its last row to the one below.
Problem WithNewLink(const std::vector<Pose>& truth, uint64_t seed) {
  GraphMaker maker(seed);
  Problem problem;
  AddOdometry(truth, {0.05, 0.004}, &maker, &problem);
  AddRowLinks(truth, kLongRows - 1, kLongColumns, {0.03, 0.003}, &maker, &problem);
  const auto before = Optimize(problem);
  EXPECT_TRUE(before.ok());
  problem.poses = before->poses;
  const int last = static_cast<int>(truth.size()) - 1;
  problem.edges.push_back(maker.Measure(truth, last - 2 * kLongColumns + 1, last, {0.03, 0.003}));
  return problem;
}

// The largest difference of two solutions in the relative poses that edges measure: metres,
// radians.
std::pair<double, double> LargestChange(const Problem& problem, const std::vector<Pose>& before,
                                        const std::vector<Pose>& after) {
  double metres = 0, radians = 0;
  for (const Edge& edge : problem.edges) {
    const size_t a = static_cast<size_t>(edge.a), b = static_cast<size_t>(edge.b);
    const Pose T_a_b = before[a].Inverse() * before[b];
    const Pose change = T_a_b.Inverse() * (after[a].Inverse() * after[b]);
    metres = std::max(metres, change.translation().norm());
    radians = std::max(radians, RotationAngle(change));
  }
  return {metres, radians};
}

class OneNewLink : public testing::TestWithParam<int> {};

TEST_P(OneNewLink, ComesWithinMillimetresOfTheFullSolution) {
  const std::vector<Pose> truth = Grid(kLongRows, kLongColumns);
  const Problem problem = WithNewLink(truth, static_cast<uint64_t>(GetParam()));
  const auto around = OptimizeAround(problem, {static_cast<int>(problem.edges.size()) - 1});
  const auto full = Optimize(problem);
  ASSERT_TRUE(around.ok() && full.ok()) << around.status() << full.status();
  EXPECT_TRUE(around->converged);
  // The link does change something: here ...
  EXPECT_GT(LargestChange(problem, problem.poses, full->poses).first, 0.01);
  EXPECT_GT(LargestDistance(problem.poses, full->poses), 0.1);
  // ... and neighbours come to lie to each other as in the full solution. The rest adds up over the
  // map to a slow bend.
  const auto [metres, radians] = LargestChange(problem, around->poses, full->poses);
  EXPECT_LT(metres, 0.002);
  EXPECT_LT(radians, 0.0002);
  EXPECT_LT(LargestDistance(around->poses, full->poses),
            0.25 * LargestDistance(problem.poses, full->poses));
  EXPECT_LT(around->free_nodes, 500);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OneNewLink, testing::Range(1, 6));

TEST(OptimizeAround, LeavesAllElseUntouched) {
  const std::vector<Pose> truth = Grid(kLongRows, kLongColumns);
  const Problem problem = WithNewLink(truth, 7);
  const auto around = OptimizeAround(problem, {static_cast<int>(problem.edges.size()) - 1});
  ASSERT_TRUE(around.ok()) << around.status();
  int moved = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    moved += around->poses[i].Matrix() != problem.poses[i].Matrix();
  }
  EXPECT_LE(moved, around->free_nodes);
  EXPECT_GT(moved, 20);
}

TEST(OptimizeAround, NothingNewChangesNothing) {
  const std::vector<Pose> truth = Grid(kLongRows, kLongColumns);
  const Problem problem = WithNewLink(truth, 8);
  const auto around = OptimizeAround(problem, {});
  ASSERT_TRUE(around.ok()) << around.status();
  EXPECT_EQ(LargestDistance(around->poses, problem.poses), 0);
  EXPECT_EQ(around->free_nodes, 0);
}

TEST(OptimizeAround, DiscardsAFalseEdgeAndLeavesOutWhatWasDiscarded) {
  const std::vector<Pose> truth = Grid(kLongRows, kLongColumns);
  Problem problem = WithNewLink(truth, 9);
  const auto settled = Optimize(problem);
  ASSERT_TRUE(settled.ok());
  problem.poses = settled->poses;
  GraphMaker maker(10);
  Edge known = maker.Measure(truth, 30, 400, {});
  known.T_a_b = Pose(Eigen::Vector3d(3, 0, 0)) * known.T_a_b;
  known.may_be_wrong = true;
  known.weight = 0;
  Edge fresh = maker.Measure(truth, 100, 250, {});
  fresh.T_a_b = Pose(Eigen::Vector3d(0, 4, 0)) * fresh.T_a_b;
  fresh.may_be_wrong = true;
  problem.edges.push_back(known);
  problem.edges.push_back(fresh);
  const int last = static_cast<int>(problem.edges.size()) - 1;
  const auto around = OptimizeAround(problem, {last});
  ASSERT_TRUE(around.ok()) << around.status();
  EXPECT_EQ(around->edge_weights[problem.edges.size() - 1], 0);
  EXPECT_EQ(around->edge_weights[problem.edges.size() - 2], 0);
  EXPECT_LT(LargestDistance(around->poses, problem.poses), 0.005);
}

TEST(OptimizeAround, JoinsAComponentThatWasFarAway) {
  GraphMaker maker(11);
  const std::vector<Pose> truth = Ring(60, 30);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  problem.edges.erase(problem.edges.begin() + 29);  // 0-29 and 30-59.
  for (size_t i = 30; i < 60; ++i) {
    problem.poses[i] = Pose::FromXyzRpy(50, 0, 0, 0, 0, 0.3) * problem.poses[i];
  }
  problem.edges.push_back(maker.Measure(truth, 0, 59, {}, true));
  const auto around = OptimizeAround(problem, {static_cast<int>(problem.edges.size()) - 1});
  ASSERT_TRUE(around.ok()) << around.status();
  EXPECT_LT(LargestDistance(around->poses, truth), 0.02);
}

TEST(OptimizeAround, RefusesAnEdgeThatDoesNotExist) {
  GraphMaker maker(12);
  const std::vector<Pose> truth = Ring(5, 3);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem);
  for (const int edge : {-1, 4}) {
    EXPECT_EQ(OptimizeAround(problem, {edge}).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace isthmus::pose_graph
