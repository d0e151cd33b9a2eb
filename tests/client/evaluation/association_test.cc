#include "client/evaluation/association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace isthmus::evaluation {
namespace {

constexpr int64_t kMs = 1'000'000;

StampedPose At(int64_t stamp_ms, double x) {
  return {stamp_ms * kMs, Pose(Eigen::Vector3d(x, 0, 0))};
}

TEST(Associate, NothingInCommonIsNoPair) {
  EXPECT_TRUE(Associate({At(0, 0), At(100, 1)}, {At(5000, 0)}, 0.02).empty());
  EXPECT_TRUE(Associate({}, {At(0, 0)}, 0.02).empty());
  EXPECT_TRUE(Associate({At(0, 0)}, {}, 0.02).empty());
}

TEST(Associate, TheToleranceIsTheLargestDifferenceThatCounts) {
  const Trajectory truth = {At(0, 0), At(100, 1)};
  EXPECT_EQ(Associate(truth, {At(20, 0), At(121, 1)}, 0.02).size(), 1u);
  EXPECT_EQ(Associate(truth, {At(20, 0), At(121, 1)}, 0.021).size(), 2u);
  EXPECT_EQ(Associate(truth, {At(-20, 0)}, 0.02).size(), 1u) << "before the truth begins";
}

TEST(Associate, AFasterEstimateUsesEachTruthOnce) {
  Trajectory truth, estimate;
  for (int i = 0; i < 10; ++i) truth.push_back(At(100 * i, i));
  for (int i = 0; i < 100; ++i) estimate.push_back(At(10 * i + 1, 0.1 * i));
  const std::vector<PosePair> pairs = Associate(truth, estimate, 0.05);
  ASSERT_EQ(pairs.size(), 10u);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(pairs[i].stamp_ns, (100 * i + 1) * kMs) << "the nearest in time";
    EXPECT_DOUBLE_EQ(pairs[i].estimate.translation().x(), pairs[i].truth.translation().x());
  }
}

TEST(Associate, ASlowerEstimateKeepsAllItsPoses) {
  Trajectory truth, estimate;
  for (int i = 0; i < 100; ++i) truth.push_back(At(10 * i, 0.1 * i));
  for (int i = 0; i < 10; ++i) estimate.push_back(At(100 * i + 4, i));
  const std::vector<PosePair> pairs = Associate(truth, estimate, 0.02);
  ASSERT_EQ(pairs.size(), 10u);
  EXPECT_DOUBLE_EQ(pairs[3].truth.translation().x(), 3);
}

TEST(Associate, OrderInTheFilesDoesNotMatter) {
  Trajectory truth, estimate;
  for (int i = 0; i < 50; ++i) {
    truth.push_back(At(100 * i, i));
    estimate.push_back(At(100 * i + 7, i));
  }
  std::mt19937 random(1);
  std::shuffle(truth.begin(), truth.end(), random);
  std::shuffle(estimate.begin(), estimate.end(), random);
  const std::vector<PosePair> pairs = Associate(truth, estimate, 0.02);
  ASSERT_EQ(pairs.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    EXPECT_DOUBLE_EQ(pairs[i].truth.translation().x(), i);
    EXPECT_DOUBLE_EQ(pairs[i].estimate.translation().x(), i);
  }
}

TEST(Associate, DoubledStampsAreOnePose) {
  const Trajectory truth = {At(0, 0), At(100, 1)};
  EXPECT_EQ(Associate(truth, {At(0, 0), At(0, 0.5), At(100, 1)}, 0.02).size(), 2u);
}

TEST(WayAlongTruth, IsTheSumOfTheSteps) {
  const std::vector<PosePair> pairs = {{0, Pose(Eigen::Vector3d(0, 0, 0)), Pose()},
                                       {1, Pose(Eigen::Vector3d(3, 4, 0)), Pose()},
                                       {2, Pose(Eigen::Vector3d(3, 4, 2)), Pose()}};
  EXPECT_EQ(WayAlongTruth(pairs), (std::vector<double>{0, 5, 7}));
  EXPECT_TRUE(WayAlongTruth({}).empty());
}

}  // namespace
}  // namespace isthmus::evaluation
