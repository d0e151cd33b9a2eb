#include "floam/relocalise/pose_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace isthmus::floam {
namespace {

constexpr int kWidth = 64, kMargin = 16;

// Walls at random, with flat ground and the unknown in between.
WallImage RandomImage(unsigned seed) {
  WallImage image;
  image.width = kWidth;
  image.margin = kMargin;
  image.corner = {-7.5, 3.25};
  image.values.resize(kWidth * kWidth);
  image.standable.assign(kWidth * kWidth, 1);
  std::mt19937 random(seed);
  for (int8_t& value : image.values) {
    const unsigned kind = random() % 10;
    value = kind == 0  ? WallImage::kWall
            : kind < 3 ? WallImage::kNearWall
            : kind < 6 ? WallImage::kUnknown
                       : WallImage::kFlat;
  }
  return image;
}

std::vector<Eigen::Vector2f> RandomWalls(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-4, 4);
  std::vector<Eigen::Vector2f> walls;
  for (int k = 0; k < 15; ++k) walls.emplace_back(coordinate(random), coordinate(random));
  return walls;
}

double ScoreAt(const WallImage& image, const std::vector<Eigen::Vector2i>& offsets, int x, int y) {
  int sum = 0;
  for (const Eigen::Vector2i& o : offsets) sum += image.values[(y + o.y()) * kWidth + x + o.x()];
  return sum / (static_cast<double>(WallImage::kWall) * static_cast<double>(offsets.size()));
}

double BruteForce(const WallImage& image, const std::vector<Eigen::Vector2f>& walls) {
  const int headings = static_cast<int>(std::ceil(2 * std::numbers::pi / HeadingStep(walls)));
  double best = -1;
  for (int k = 0; k < headings; ++k) {
    const auto offsets = WallOffsets(walls, 2 * std::numbers::pi * k / headings - std::numbers::pi);
    for (int y = kMargin; y < kWidth - kMargin; ++y) {
      for (int x = kMargin; x < kWidth - kMargin; ++x) {
        if (image.standable[y * kWidth + x]) best = std::max(best, ScoreAt(image, offsets, x, y));
      }
    }
  }
  return best;
}

TEST(MaxPyramid, BoundsEveryCellOfItsBlocksAndIsReachedByOne) {
  const WallImage image = RandomImage(1);
  const MaxPyramid pyramid(image, 4);
  for (int level = 0; level < pyramid.levels(); ++level) {
    const int size = 1 << level;
    for (int y = 0; y < kWidth; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        int largest = x + size > kWidth || y + size > kWidth ? WallImage::kUnknown : -128;
        for (int cy = y; cy < std::min(y + size, kWidth); ++cy) {
          for (int cx = x; cx < std::min(x + size, kWidth); ++cx) {
            largest = std::max<int>(largest, image.values[cy * kWidth + cx]);
          }
        }
        ASSERT_EQ(pyramid.Level(level)[y * kWidth + x], largest) << level << " " << x << " " << y;
      }
    }
  }
}

TEST(PoseSearch, FindsWhatTryingEveryPoseFinds) {
  PoseSearchOptions options;
  options.min_score = -0.5;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const WallImage image = RandomImage(seed);
    const std::vector<Eigen::Vector2f> walls = RandomWalls(100 + seed);
    const PoseSearchResult result = SearchPoses(image, walls, options);
    ASSERT_TRUE(result.complete);
    ASSERT_FALSE(result.found.empty());
    EXPECT_DOUBLE_EQ(result.found[0].score, BruteForce(image, walls)) << seed;
    for (size_t k = 1; k < result.found.size(); ++k) {
      EXPECT_LE(result.found[k].score, result.found[k - 1].score);
    }
  }
}

TEST(PoseSearch, FindsOnlyWhereTheSensorMayBe) {
  WallImage image = RandomImage(3);
  const std::vector<Eigen::Vector2f> walls = RandomWalls(103);
  std::fill(image.standable.begin(), image.standable.end(), 0);
  for (int y = 20; y < 23; ++y) {
    for (int x = 30; x < 35; ++x) image.standable[y * kWidth + x] = 1;
  }
  PoseSearchOptions options;
  options.min_score = -0.5;
  const PoseSearchResult result = SearchPoses(image, walls, options);
  ASSERT_FALSE(result.found.empty());
  EXPECT_DOUBLE_EQ(result.found[0].score, BruteForce(image, walls));
  for (const FoundPose& found : result.found) {
    const Eigen::Vector2d cell = (found.position - image.corner) / MapMemory::kCellM;
    EXPECT_GE(cell.x(), 30);
    EXPECT_LT(cell.x(), 35);
    EXPECT_GE(cell.y(), 20);
    EXPECT_LT(cell.y(), 23);
  }
}

TEST(PoseSearch, FindsPosesThatAreApartAndGoodEnough) {
  const WallImage image = RandomImage(5);
  const std::vector<Eigen::Vector2f> walls = RandomWalls(105);
  PoseSearchOptions options;
  options.min_score = 0.3;
  options.max_found = 4;
  const PoseSearchResult result = SearchPoses(image, walls, options);
  EXPECT_LE(result.found.size(), 4u);
  ASSERT_GE(result.found.size(), 2u);
  for (size_t a = 0; a < result.found.size(); ++a) {
    EXPECT_GE(result.found[a].score, options.min_score);
    for (size_t b = 0; b < a; ++b) {
      const double turned =
          std::remainder(result.found[a].yaw - result.found[b].yaw, 2 * std::numbers::pi);
      EXPECT_TRUE((result.found[a].position - result.found[b].position).norm() >= options.apart_m ||
                  std::abs(turned) >= options.apart_rad);
    }
  }
}

TEST(PoseSearch, FindsWallsTurnedAndMovedAsTheyAre) {
  // An L of walls in an empty image, seen by a sensor turned by 2.5 rad.
  WallImage image;
  image.width = kWidth;
  image.margin = kMargin;
  image.values.assign(kWidth * kWidth, WallImage::kFlat);
  image.standable.assign(kWidth * kWidth, 1);
  const Eigen::Vector2d sensor(11.4, 13.4);
  const double yaw = 2.5;
  std::vector<Eigen::Vector2f> walls;
  const auto add = [&](int x, int y) {
    image.values[y * kWidth + x] = WallImage::kWall;
    const Eigen::Vector2d seen = Eigen::Rotation2Dd(-yaw) * (image.CentreOf(x, y) - sensor);
    walls.push_back(seen.cast<float>());
  };
  for (int k = 0; k < 14; ++k) add(22 + k, 40);
  for (int k = 0; k < 7; ++k) add(22, 39 - k);
  const PoseSearchResult result = SearchPoses(image, walls, PoseSearchOptions());
  ASSERT_FALSE(result.found.empty());
  EXPECT_LT((result.found[0].position - sensor).norm(), 0.6);
  EXPECT_NEAR(result.found[0].yaw, yaw, 0.1);
  EXPECT_GT(result.found[0].score, 0.8);
}

TEST(PoseSearch, SaysWhenItGaveUp) {
  PoseSearchOptions options;
  options.min_score = -0.5;
  options.max_lookups = 1000;
  const PoseSearchResult result = SearchPoses(RandomImage(1), RandomWalls(101), options);
  EXPECT_FALSE(result.complete);
  EXPECT_TRUE(SearchPoses(RandomImage(1), {}, PoseSearchOptions()).complete);
}

}  // namespace
}  // namespace isthmus::floam
