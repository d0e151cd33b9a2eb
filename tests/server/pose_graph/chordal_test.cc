#include "server/pose_graph/chordal.h"

#include <gtest/gtest.h>

#include "server/pose_graph/optimize.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

// A grid with links between rows, at what its odometry adds up to.
Problem NoisyGrid(uint64_t seed, const EdgeNoise& noise, std::vector<Pose>* truth) {
  constexpr int kSide = 12;
  *truth = Grid(kSide, kSide);
  GraphMaker maker(seed);
  Problem problem;
  AddOdometry(*truth, noise, &maker, &problem);
  AddRowLinks(*truth, kSide, kSide, noise, &maker, &problem);
  return problem;
}

TEST(Chordal, ExactEdgesGiveTheTruthWithoutAStart) {
  std::vector<Pose> truth = Grid(4, 5);
  GraphMaker maker(1);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  problem.edges.push_back(maker.Measure(truth, 2, 17, {}, true));
  problem.edges.push_back(maker.Measure(truth, 19, 4, {}, true));
  for (size_t i = 1; i < problem.poses.size(); ++i) {
    problem.poses[i] = i == 9 ? truth[9] : maker.RandomPose(100, 3);
  }
  problem.fixed = {0, 9};
  const auto poses = ChordalPoses(problem);
  ASSERT_TRUE(poses.has_value());
  EXPECT_LT(LargestDistance(*poses, truth), 1e-9);
}

TEST(Chordal, PartsWithoutTiesKeepTheirLowestNode) {
  Problem problem;
  problem.poses.assign(4, Pose());
  problem.poses[2] = Pose(Eigen::Vector3d(50, 0, 0));
  problem.edges.push_back({0, 1, Pose(Eigen::Vector3d(1, 0, 0))});
  problem.edges.push_back({3, 2, Pose(Eigen::Vector3d(0, 1, 0))});
  const auto poses = ChordalPoses(problem);
  ASSERT_TRUE(poses.has_value());
  EXPECT_LT(((*poses)[1].translation() - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT(((*poses)[2].translation() - Eigen::Vector3d(50, 0, 0)).norm(), 1e-12);
  EXPECT_LT(((*poses)[3].translation() - Eigen::Vector3d(50, -1, 0)).norm(), 1e-12);
}

// From the bad start Optimize reaches a local minimum.
TEST(Chordal, ABadStartIsReplacedByOneThatReachesTheMinimum) {
  std::vector<Pose> truth;
  Problem problem = NoisyGrid(3, {0.1, 0.1}, &truth);
  Problem at_truth = problem;
  at_truth.poses = truth;
  GraphMaker maker(4);
  for (size_t i = 1; i < problem.poses.size(); ++i) problem.poses[i] = maker.RandomPose(50, 3);
  const auto from_truth = Optimize(at_truth), from_nowhere = Optimize(problem);
  ASSERT_TRUE(from_truth.ok() && from_nowhere.ok());
  EXPECT_GT(from_nowhere->final_chi2, 1.05 * from_truth->final_chi2);
  const auto start = BetterStart(problem, 16.81);
  ASSERT_TRUE(start.has_value());
  problem.poses = *start;
  const auto from_chordal = Optimize(problem);
  ASSERT_TRUE(from_chordal.ok());
  EXPECT_LT(from_chordal->final_chi2, 1.001 * from_truth->final_chi2);
}

TEST(Chordal, AGoodStartIsKept) {
  std::vector<Pose> truth;
  Problem problem = NoisyGrid(4, {}, &truth);
  problem.poses = Optimize(problem)->poses;
  EXPECT_FALSE(BetterStart(problem, 16.81).has_value());
  EXPECT_FALSE(BetterStart({}, 16.81).has_value());
}

}  // namespace
}  // namespace isthmus::pose_graph
