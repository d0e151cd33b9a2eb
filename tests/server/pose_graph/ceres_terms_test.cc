#include "server/pose_graph/ceres_terms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "server/pose_graph/information.h"
#include "tests/server/pose_graph/graphs.h"

namespace isthmus::pose_graph {
namespace {

Matrix6d RandomInformation(GraphMaker* maker) {
  Matrix6d A;
  for (int i = 0; i < 6; ++i) A.col(i) = maker->RandomTwist(1, 1);
  return A * A.transpose() + 0.01 * Matrix6d::Identity();
}

using Matrix67 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

// The largest difference between analytic and numeric Jacobians, in the tangent space.
double LargestDifference(const ceres::CostFunction& term, const std::vector<PoseBlock>& blocks) {
  const PoseManifold manifold;
  double largest = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    std::vector<const double*> at;
    for (const PoseBlock& block : blocks) at.push_back(block.data());
    Vector6d residual;
    Matrix67 ambient;
    std::vector<double*> wanted(blocks.size(), nullptr);
    wanted[i] = ambient.data();
    EXPECT_TRUE(term.Evaluate(at.data(), residual.data(), wanted.data()));
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> lift;
    manifold.PlusJacobian(at[i], lift.data());
    const Matrix6d analytic = ambient * lift;
    Matrix6d numeric;
    for (int k = 0; k < 6; ++k) {
      Vector6d ends[2];
      for (const int side : {0, 1}) {
        const Vector6d d = (side == 0 ? -1e-5 : 1e-5) * Vector6d::Unit(k);
        PoseBlock moved;
        manifold.Plus(blocks[i].data(), d.data(), moved.data());
        at[i] = moved.data();
        EXPECT_TRUE(term.Evaluate(at.data(), ends[side].data(), nullptr));
        at[i] = blocks[i].data();
      }
      numeric.col(k) = (ends[1] - ends[0]) / 2e-5;
    }
    EXPECT_GT(numeric.cwiseAbs().maxCoeff(), 0.01);
    largest = std::max(largest, (analytic - numeric).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(PoseManifold, MinusUndoesPlus) {
  GraphMaker maker(1);
  const PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const PoseBlock x = ToBlock(maker.RandomPose(100, 3));
    const Vector6d delta = maker.RandomTwist(2, 3);
    PoseBlock y;
    Vector6d back;
    manifold.Plus(x.data(), delta.data(), y.data());
    manifold.Minus(y.data(), x.data(), back.data());
    EXPECT_LT((back - delta).norm(), 1e-10);
  }
}

TEST(PoseManifold, JacobiansAreDerivativesAndInverses) {
  GraphMaker maker(2);
  const PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const PoseBlock x = ToBlock(maker.RandomPose(10, 3));
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
    manifold.PlusJacobian(x.data(), plus.data());
    manifold.MinusJacobian(x.data(), minus.data());
    EXPECT_LT((minus * plus - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = 1e-6 * Vector6d::Unit(k);
      const Vector6d minus_d = -d;
      Eigen::Matrix<double, 7, 1> forward, backward;
      manifold.Plus(x.data(), d.data(), forward.data());
      manifold.Plus(x.data(), minus_d.data(), backward.data());
      EXPECT_LT(((forward - backward) / 2e-6 - plus.col(k)).norm(), 1e-8);
    }
  }
}

TEST(EdgeTerm, JacobiansAgreeWithNumericOnes) {
  GraphMaker maker(3);
  for (int i = 0; i < 30; ++i) {
    const Pose T_map_a = maker.RandomPose(20, 3), T_map_b = maker.RandomPose(20, 3);
    // Errors from nothing to a radian and metres.
    const Pose T_a_b = Exp(maker.RandomTwist(0.1 * i, i / 30.0)) * T_map_a.Inverse() * T_map_b;
    const Matrix6d root = *SquareRootInformation(RandomInformation(&maker));
    const double weight = 0.3;
    const EdgeTerm term(T_a_b, root, &weight);
    EXPECT_LT(LargestDifference(term, {ToBlock(T_map_a), ToBlock(T_map_b)}), 1e-7) << i;
  }
}

TEST(AnchorTerm, JacobiansAgreeWithNumericOnes) {
  GraphMaker maker(4);
  for (int i = 0; i < 30; ++i) {
    const Pose pose = maker.RandomPose(20, 3);
    const Pose anchor = maker.RandomPose(20, 1) * pose;
    const Matrix6d root = *SquareRootInformation(RandomInformation(&maker));
    const double weight = 0.7;
    const AnchorTerm term(anchor, root, &weight);
    EXPECT_LT(LargestDifference(term, {ToBlock(pose)}), 1e-7) << i;
  }
}

// Half the squared residual is what Chi2 says, whatever the shape of the information: fails when
// L is taken for L^T.
TEST(EdgeTerm, SquaredResidualIsWeightedChi2) {
  GraphMaker maker(5);
  for (int i = 0; i < 10; ++i) {
    Problem problem;
    problem.poses = {maker.RandomPose(5, 2), maker.RandomPose(5, 2)};
    Edge edge;
    edge.b = 1;
    edge.T_a_b = maker.RandomPose(5, 2);
    edge.information = RandomInformation(&maker);
    const double weight = 0.25;
    const EdgeTerm term(edge.T_a_b, *SquareRootInformation(edge.information), &weight);
    const PoseBlock a = ToBlock(problem.poses[0]), b = ToBlock(problem.poses[1]);
    const double* blocks[] = {a.data(), b.data()};
    Vector6d residual;
    ASSERT_TRUE(term.Evaluate(blocks, residual.data(), nullptr));
    EXPECT_NEAR(residual.squaredNorm(), weight * Chi2(problem, edge), 1e-9 * Chi2(problem, edge));
  }
}

}  // namespace
}  // namespace isthmus::pose_graph
