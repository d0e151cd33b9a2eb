#include "server/pose_graph/optimize.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/se3.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

Problem NoisyRing(const std::vector<Pose>& truth, uint64_t seed) {
  GraphMaker maker(seed);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem);
  problem.edges.push_back(
      maker.Measure(truth, static_cast<int>(truth.size()) - 1, 0, {0.005, 0.0005}));
  return problem;
}

TEST(Optimize, EmptyProblemHasEmptyResult) {
  const auto result = Optimize({});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->poses.empty());
  EXPECT_TRUE(result->converged);
}

TEST(Optimize, NoiseFreeLoopRecoversTheTruthFromABadStart) {
  const std::vector<Pose> truth = Ring(60, 30);
  GraphMaker maker(1);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  problem.edges.push_back(maker.Measure(truth, 59, 0, {}, true));
  problem.edges.push_back(maker.Measure(truth, 10, 45, {}, true));
  for (size_t i = 1; i < problem.poses.size(); ++i) {
    problem.poses[i] = problem.poses[i] * Exp(maker.RandomTwist(2, 0.5));
  }
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->converged);
  EXPECT_GT(result->initial_chi2, 1e6);
  EXPECT_LT(result->final_chi2, 1e-6);
  EXPECT_LT(LargestDistance(result->poses, truth), 1e-5);
}

TEST(Optimize, ClosingALoopRemovesDrift) {
  const std::vector<Pose> truth = Ring(200, 50);
  double before = 0, after = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem problem = NoisyRing(truth, seed);
    const auto result = Optimize(problem);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_TRUE(result->converged);
    EXPECT_LT(result->final_chi2, 30);  // 6 more measurements than unknowns.
    before += Rmse(problem.poses, truth);
    after += Rmse(result->poses, truth);
  }
  EXPECT_LT(after, 0.5 * before);
}

// The gradient of the sum of e^T information e vanishes at the result: by numeric differences of
// Chi2, which knows nothing of square roots. With L in the place of L^T it would not.
TEST(Optimize, ResultIsAMinimumOfTheSumOfChi2) {
  GraphMaker maker(3);
  const std::vector<Pose> truth = Ring(8, 10);
  Problem problem;
  AddOdometry(truth, {0.1, 0.02}, &maker, &problem);
  problem.edges.push_back(maker.Measure(truth, 7, 0, {0.1, 0.02}));
  problem.edges.push_back(maker.Measure(truth, 2, 6, {0.1, 0.02}));
  for (Edge& edge : problem.edges) {
    Matrix6d L = edge.information.cwiseSqrt();
    for (int row = 1; row < 6; ++row) L(row, 0) = 30 * std::sin(row);
    edge.information = L * L.transpose();
  }
  problem.anchors.push_back(
      {3, truth[3] * Exp(maker.RandomTwist(0.1, 0.01)), 1e3 * Matrix6d::Identity()});
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  Problem at = problem;
  at.poses = result->poses;
  const auto total = [&] {
    double sum = 0;
    for (const Edge& edge : at.edges) sum += Chi2(at, edge);
    for (const Anchor& anchor : at.anchors) sum += Chi2(at, anchor);
    return sum;
  };
  EXPECT_NEAR(total(), result->final_chi2, 1e-9 * result->final_chi2);
  EXPECT_GT(result->final_chi2, 0.1);
  for (size_t node = 1; node < at.poses.size(); ++node) {
    for (int k = 0; k < 6; ++k) {
      const Pose here = at.poses[node];
      const double step = 1e-4;
      at.poses[node] = here * Exp(step * Vector6d::Unit(k));
      const double forward = total();
      at.poses[node] = here * Exp(-step * Vector6d::Unit(k));
      const double backward = total();
      at.poses[node] = here;
      // The minimum of the parabola through the three lies where we are.
      const double curvature = forward + backward - 2 * result->final_chi2;
      EXPECT_LT(std::abs(forward - backward) / 2 / curvature * step, 2e-6) << node << " " << k;
    }
  }
}

TEST(Optimize, LowestNodeOfEachComponentIsHeld) {
  const std::vector<Pose> truth = Ring(30, 10);
  Problem problem = NoisyRing(truth, 4);
  const Problem other = NoisyRing(truth, 5);
  for (Edge edge : other.edges) {
    edge.a += 30;
    edge.b += 30;
    problem.edges.push_back(edge);
  }
  const Pose T_map_other = Pose::FromXyzRpy(100, 50, 0, 0, 0, 2);
  for (const Pose& pose : other.poses) problem.poses.push_back(T_map_other * pose);
  problem.poses.push_back(Pose(Eigen::Vector3d(7, 7, 7)));  // On its own.
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->held, (std::vector<int>{0, 30, 60}));
  for (const int held : result->held) {
    const size_t i = static_cast<size_t>(held);
    EXPECT_EQ(result->poses[i].Matrix(), problem.poses[i].Matrix());
  }
  // Each component is solved as if it were alone.
  const auto alone = Optimize(other);
  ASSERT_TRUE(alone.ok());
  for (size_t i = 0; i < 30; ++i) {
    const Pose expected = T_map_other * alone->poses[i];
    EXPECT_LT((result->poses[30 + i].translation() - expected.translation()).norm(), 1e-5);
  }
}

TEST(Optimize, FixedNodesStayInPlaceOfTheLowest) {
  const std::vector<Pose> truth = Ring(30, 10);
  Problem problem = NoisyRing(truth, 6);
  problem.fixed = {17, 17};
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->held, (std::vector<int>{17}));
  EXPECT_EQ(result->poses[17].Matrix(), problem.poses[17].Matrix());
  // Another gauge, the same shape.
  Problem from_first = problem;
  from_first.fixed.clear();
  const auto first = Optimize(from_first);
  ASSERT_TRUE(first.ok());
  EXPECT_NEAR(first->final_chi2, result->final_chi2, 1e-6);
  EXPECT_NEAR(Rmse(first->poses, truth), Rmse(result->poses, truth), 1e-4);
}

// A corridor: edges say nothing along x. Another edge does, and alone decides it.
TEST(Optimize, EdgesWithoutInformationAlongADirectionPullNothingThere) {
  const std::vector<Pose> truth = {Pose(), Pose(Eigen::Vector3d(10, 0, 0))};
  GraphMaker maker(7);
  Problem problem;
  problem.poses = {Pose(), Pose(Eigen::Vector3d(9, 0.5, 0))};
  Edge blind = maker.Measure(truth, 0, 1, {}, true);
  blind.T_a_b = Pose(Eigen::Vector3d(4, 0, 0));
  blind.information.row(0).setZero();
  blind.information.col(0).setZero();
  Edge weak = maker.Measure(truth, 0, 1, {1, 1}, true);
  problem.edges = {blind, weak};
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(LargestDistance(result->poses, truth), 1e-5);
}

TEST(Optimize, WhatNothingDeterminesStaysWhereItWas) {
  Problem problem;
  problem.poses = {Pose(), Pose(Eigen::Vector3d(9, 0.5, 0))};
  Edge blind;
  blind.b = 1;
  blind.T_a_b = Pose(Eigen::Vector3d(4, 0, 0));
  blind.information(0, 0) = 0;
  problem.edges = {blind};
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_NEAR(result->poses[1].translation().x(), 9, 1e-3);
  EXPECT_NEAR(result->poses[1].translation().y(), 0, 1e-6);
}

TEST(Optimize, AFullAnchorPlacesItsComponent) {
  const std::vector<Pose> truth = Ring(30, 10);
  GraphMaker maker(8);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  const Pose T_map_local = Pose::FromXyzRpy(50, 20, 1, 0, 0, 1);
  problem.anchors.push_back({12, T_map_local * truth[12], 1e4 * Matrix6d::Identity()});
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->held.empty());
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((result->poses[i].translation() - (T_map_local * truth[i]).translation()).norm(),
              1e-4);
  }
}

Anchor Position(int node, const Eigen::Vector3d& p, double sigma) {
  Anchor anchor;
  anchor.node = node;
  anchor.T_map_node = Pose(p);  // The heading is not known: no information, any number.
  anchor.information.setZero();
  anchor.information.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() / (sigma * sigma);
  return anchor;
}

TEST(Optimize, PositionsAlonePlaceAndTurnAMap) {
  const std::vector<Pose> truth = Ring(30, 10);
  GraphMaker maker(9);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  const Pose T_map_local = Pose::FromXyzRpy(50, 20, 1, 0, 0, 2);
  for (const int node : {0, 9, 20}) {
    const size_t i = static_cast<size_t>(node);
    problem.anchors.push_back(Position(node, T_map_local * truth[i].translation(), 0.5));
  }
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((result->poses[i].translation() - (T_map_local * truth[i]).translation()).norm(),
              1e-3);
  }
}

TEST(Optimize, OnePositionMovesAMapWithoutBendingIt) {
  const std::vector<Pose> truth = Ring(30, 10);
  GraphMaker maker(10);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem, true);
  const Eigen::Vector3d shift(30, -20, 2);
  problem.anchors.push_back(Position(12, truth[12].translation() + shift, 2));
  const auto result = Optimize(problem);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT((result->poses[12].translation() - truth[12].translation() - shift).norm(), 0.01);
  EXPECT_LT(Rmse(result->poses, truth), 0.5);  // Turned hardly, bent not at all.
  EXPECT_LT(result->final_chi2, 0.01);
}

TEST(Optimize, IsDeterministic) {
  const std::vector<Pose> truth = Grid(6, 20);
  GraphMaker maker(11);
  Problem problem;
  AddOdometry(truth, {}, &maker, &problem);
  AddRowLinks(truth, 6, 20, {}, &maker, &problem);
  const auto first = Optimize(problem), second = Optimize(problem);
  ASSERT_TRUE(first.ok() && second.ok());
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(first->poses[i].Matrix(), second->poses[i].Matrix());
  }
}

TEST(Optimize, StopsWhenToldTo) {
  const std::vector<Pose> truth = Ring(200, 50);
  Options options;
  options.max_iterations = 1;
  const auto result = Optimize(NoisyRing(truth, 2), options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(result->converged);
  EXPECT_EQ(result->iterations, 1);
  EXPECT_LT(result->final_chi2, result->initial_chi2);
}

TEST(Optimize, RefusesNonsenseAndNamesIt) {
  const Problem good = NoisyRing(Ring(5, 3), 1);
  std::vector<Problem> bad(9, good);
  bad[0].edges[2].b = 5;
  bad[1].edges[2].a = -1;
  bad[2].edges[2].b = bad[2].edges[2].a;
  bad[3].edges[2].information(0, 0) = std::numeric_limits<double>::infinity();
  bad[4].edges[2].T_a_b = Pose(Eigen::Vector3d(0, std::nan(""), 0));
  bad[5].edges[2].information = -Matrix6d::Identity();
  bad[6].edges[2].information(0, 1) += 1000;
  bad[7].poses[2] = Pose(Eigen::Vector3d(1e300, 0, 0));
  bad[8].fixed = {2, 5};
  for (size_t i = 0; i < bad.size(); ++i) {
    const auto result = Optimize(bad[i]);
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument) << i;
    if (i >= 7) continue;
    EXPECT_NE(result.status().message().find("edge 2"), std::string::npos) << i;
  }
  Problem bad_anchor = good;
  bad_anchor.anchors.push_back({5, Pose(), Matrix6d::Identity()});
  EXPECT_EQ(Optimize(bad_anchor).status().code(), absl::StatusCode::kInvalidArgument);
  bad_anchor.anchors[0] = {0, Pose(), -Matrix6d::Identity()};
  EXPECT_EQ(Optimize(bad_anchor).status().code(), absl::StatusCode::kInvalidArgument);
  Options options;
  options.max_iterations = 0;
  EXPECT_EQ(Optimize(good, options).status().code(), absl::StatusCode::kInvalidArgument);
}

// Numbers that are finite but overflow when squared: an answer or an error, never an abort.
TEST(Optimize, SurvivesHugeInformation) {
  Problem problem = NoisyRing(Ring(5, 3), 1);
  problem.edges[1].information = 1e300 * Matrix6d::Identity();
  problem.poses[2] = Pose(Eigen::Vector3d(9e8, 0, 0));
  const auto result = Optimize(problem);
  if (result.ok()) {
    for (const Pose& pose : result->poses) EXPECT_TRUE(pose.IsFinite());
  } else {
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInternal);
  }
}

}  // namespace
}  // namespace isthmus::pose_graph
