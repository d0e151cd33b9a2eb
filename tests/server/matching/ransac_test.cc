#include "server/matching/paper/ransac.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>

namespace isthmus::matching {
namespace {

const Pose kTruth = Pose::FromXyzRpy(40, -15, 2, 0.05, -0.1, 2.5);

class Points {
 public:
  explicit Points(unsigned seed) : rng_(seed) {}
  Eigen::Vector3f Next(float extent) {
    std::uniform_real_distribution<float> uniform(-extent, extent);
    const float x = uniform(rng_), y = uniform(rng_), z = 0.2f * uniform(rng_);
    return {x, y, z};
  }

 private:
  std::mt19937 rng_;
};

std::vector<PointPair> TruePairs(const Pose& T_a_b, int count, float noise_m, Points* points) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f b = points->Next(20);
    pairs.push_back({(T_a_b * b.cast<double>()).cast<float>() + points->Next(noise_m), b});
  }
  return pairs;
}

void AddWrongPairs(int count, Points* points, std::vector<PointPair>* pairs) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f a = points->Next(20) + kTruth.translation().cast<float>();
    pairs->push_back({a, points->Next(20)});
  }
}

RansacOptions Options() {
  RansacOptions options;
  options.iterations = 20000;
  return options;
}

TEST(FitRigid, FindsTheTransformOfExactPairs) {
  Points points(1);
  const auto pairs = TruePairs(kTruth, 10, 0, &points);
  EXPECT_LT(Log(kTruth.Inverse() * FitRigid(pairs)).norm(), 1e-4);
  EXPECT_LT(Log(kTruth.Inverse() * FitRigid(std::span(pairs).first(3))).norm(), 1e-3);
}

TEST(FitRigid, NeverAReflection) {
  // A mirrored set, which the best orthogonal matrix would flip.
  Points points(2);
  std::vector<PointPair> pairs;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector3f b = points.Next(5);
    pairs.push_back({{-b.x(), b.y(), b.z()}, b});
  }
  EXPECT_NEAR(FitRigid(pairs).RotationMatrix().determinant(), 1, 1e-9);
}

TEST(FitRigid, NothingToFitIsIdentity) {
  EXPECT_EQ(FitRigid({}).Matrix(), Eigen::Matrix4d::Identity());
}

TEST(FindConsensus, FindsTheTransformAmongEightyPercentOutliers) {
  Points points(3);
  auto pairs = TruePairs(kTruth, 40, 0.1f, &points);
  AddWrongPairs(160, &points, &pairs);
  const auto found = FindConsensus(pairs, Options());
  ASSERT_FALSE(found.empty());
  EXPECT_GE(found.front().inliers.size(), 35u);
  const Pose error = kTruth.Inverse() * found.front().T_a_b;
  EXPECT_LT(error.translation().norm(), 0.3);
  EXPECT_LT(RotationAngle(error), 0.03);
}

TEST(FindConsensus, NoConsensusAmongWrongPairsOnly) {
  Points points(4);
  std::vector<PointPair> pairs;
  AddWrongPairs(60, &points, &pairs);
  EXPECT_TRUE(FindConsensus(pairs, Options()).empty());
  EXPECT_TRUE(FindConsensus({}, Options()).empty());
}

TEST(FindConsensus, TwoDistinctTransformsAreBothFoundLargestFirst) {
  const Pose second = Pose(Eigen::Vector3d(12, 0, 0)) * kTruth;
  Points points(5);
  auto pairs = TruePairs(second, 30, 0.05f, &points);
  for (const PointPair& pair : TruePairs(kTruth, 40, 0.05f, &points)) pairs.push_back(pair);
  const auto found = FindConsensus(pairs, Options());
  ASSERT_GE(found.size(), 2u);
  EXPECT_LT((found[0].T_a_b.translation() - kTruth.translation()).norm(), 0.3);
  EXPECT_LT((found[1].T_a_b.translation() - second.translation()).norm(), 0.3);
  EXPECT_TRUE(AreDistinct(found[0].T_a_b, found[1].T_a_b, Eigen::Vector3d::Zero(), Options()));
}

TEST(FindConsensus, TiltedHypothesesAreRefusedWhereGravityIsKnown) {
  const Pose tilted = Pose::FromXyzRpy(1, 2, 3, 0.6, 0, 1);
  Points points(6);
  const auto pairs = TruePairs(tilted, 40, 0.02f, &points);
  EXPECT_FALSE(FindConsensus(pairs, Options()).empty());
  RansacOptions level = Options();
  level.max_tilt_rad = 0.3;
  for (const Consensus& consensus : FindConsensus(pairs, level)) {
    EXPECT_GE(consensus.T_a_b.RotationMatrix()(2, 2), std::cos(0.3));
  }
}

TEST(FindConsensus, EqualSeedsGiveEqualResults) {
  Points points(7);
  auto pairs = TruePairs(kTruth, 30, 0.1f, &points);
  AddWrongPairs(100, &points, &pairs);
  const auto first = FindConsensus(pairs, Options()), second = FindConsensus(pairs, Options());
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].T_a_b.Matrix(), second[i].T_a_b.Matrix());
    EXPECT_EQ(first[i].inliers, second[i].inliers);
  }
}

TEST(FindInliers, APointOfACountsOnce) {
  const Eigen::Vector3f a(1, 2, 3);
  const std::vector<PointPair> pairs = {{a, a}, {a, a + Eigen::Vector3f(0.1f, 0, 0)}};
  EXPECT_THAT(FindInliers(pairs, Pose(), 0.5), ::testing::ElementsAre(0));
}

}  // namespace
}  // namespace isthmus::matching
