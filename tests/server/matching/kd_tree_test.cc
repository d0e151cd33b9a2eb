#include "server/matching/registration/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace isthmus::matching {
namespace {

std::vector<Eigen::Vector3f> RandomPoints(int count, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(-5.0f, 5.0f);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const float x = uniform(rng), y = uniform(rng), z = uniform(rng);
    points.emplace_back(x, y, z);
  }
  return points;
}

std::vector<float> SortedDistances(const std::vector<Eigen::Vector3f>& points,
                                   const Eigen::Vector3f& query) {
  std::vector<float> distances;
  for (const Eigen::Vector3f& p : points) distances.push_back((p - query).squaredNorm());
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(KdTree, NearestAgreesWithExhaustiveSearch) {
  const auto points = RandomPoints(2000, 1);
  const KdTree tree(points);
  for (const Eigen::Vector3f& query : RandomPoints(200, 2)) {
    const KdTree::Neighbor nearest = tree.Nearest(query, 100.0f);
    ASSERT_GE(nearest.index, 0);
    EXPECT_EQ(nearest.squared_distance, SortedDistances(points, query).front());
    EXPECT_EQ(nearest.squared_distance, (points[nearest.index] - query).squaredNorm());
  }
}

TEST(KdTree, KNearestAgreesWithExhaustiveSearch) {
  const auto points = RandomPoints(1500, 3);
  const KdTree tree(points);
  std::vector<KdTree::Neighbor> neighbors;
  for (const Eigen::Vector3f& query : RandomPoints(100, 4)) {
    tree.KNearest(query, 17, 100.0f, &neighbors);
    const auto expected = SortedDistances(points, query);
    ASSERT_EQ(neighbors.size(), 17u);
    for (int i = 0; i < 17; ++i) EXPECT_EQ(neighbors[i].squared_distance, expected[i]);
  }
}

TEST(KdTree, NothingBeyondTheGivenDistance) {
  const KdTree tree({{0, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(tree.Nearest({3, 0, 0}, 1.9f).index, -1);
  EXPECT_EQ(tree.Nearest({3, 0, 0}, 2.1f).index, 1);
  std::vector<KdTree::Neighbor> neighbors;
  tree.KNearest({-0.5f, 0, 0}, 5, 1.0f, &neighbors);
  ASSERT_EQ(neighbors.size(), 1u);
  EXPECT_EQ(neighbors[0].index, 0);
}

TEST(KdTree, RefusedPointsGiveWayToTheNextNearest) {
  const KdTree tree({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  const auto neighbor = tree.NearestIf({0.1f, 0, 0}, 10.0f, [](int index) { return index != 0; });
  EXPECT_EQ(neighbor.index, 1);
}

TEST(KdTree, ManyEqualPointsAndNone) {
  const KdTree equal(std::vector<Eigen::Vector3f>(100, Eigen::Vector3f(1, 2, 3)));
  EXPECT_GE(equal.Nearest({1, 2, 3}, 0.1f).index, 0);
  std::vector<KdTree::Neighbor> neighbors;
  equal.KNearest({1, 2, 3}, 100, 0.1f, &neighbors);
  EXPECT_EQ(neighbors.size(), 100u);
  EXPECT_EQ(KdTree(std::vector<Eigen::Vector3f>{}).Nearest({0, 0, 0}, 1.0f).index, -1);
}

}  // namespace
}  // namespace isthmus::matching
