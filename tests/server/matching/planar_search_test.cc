#include "server/matching/search/planar_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "server/matching/search/planar_score.h"

namespace isthmus::matching {
namespace {

constexpr double kAnyScore = -std::numeric_limits<double>::infinity();

// Two walls of an L and the free ground inside it.
BirdsEyeCells EllOfWalls() {
  BirdsEyeCells cells;
  cells.cell_m = 0.5;
  for (int i = 0; i < 24; ++i) {
    const float along = 0.5f * static_cast<float>(i) + 0.25f;
    cells.walls.push_back({{along, 0.25f}, {0, 1}, 1});
    if (i < 14) cells.walls.push_back({{0.25f, along}, {1, 0}, 0.7f});
    if (i > 3 && i < 20) cells.free.push_back({along, 2.25f});
  }
  cells.Enclose();
  return cells;
}

// The image with so many empty cells more on every side.
BirdsEyeImage WithBorder(const BirdsEyeImage& image, int border) {
  BirdsEyeImage wider = image;
  wider.origin.array() -= static_cast<float>(border) * image.cell_m;
  wider.width += 2 * border;
  wider.rows += 2 * border;
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    wider.planes[k].assign(static_cast<size_t>(wider.width) * wider.rows, 0.0f);
    for (int y = 0; y < image.rows; ++y) {
      std::copy_n(
          image.planes[k].begin() + static_cast<std::ptrdiff_t>(y) * image.width, image.width,
          wider.planes[k].begin() + static_cast<std::ptrdiff_t>(y + border) * wider.width + border);
    }
  }
  return wider;
}

PlanarPose BestOf(const std::vector<PlanarPose>& poses) {
  return *std::ranges::max_element(poses, {}, &PlanarPose::score);
}

TEST(PlanarSearchTest, ABorderChangesNothing) {
  const BirdsEyeCells cells = EllOfWalls();
  const BirdsEyeImage image = MakeReferenceImage(cells, 1);
  const PlanarPose best = BestOf(SearchPlanar(image, cells, {}));
  const PlanarPose wider = BestOf(SearchPlanar(WithBorder(image, 17), cells, {}));
  EXPECT_NEAR(wider.yaw, best.yaw, 1e-9);
  EXPECT_LT((wider.shift - best.shift).norm(), 1e-4);
  EXPECT_NEAR(wider.score, best.score, 1e-3);
}

TEST(PlanarSearchTest, FindsAMapInItselfAndTurned) {
  const BirdsEyeCells cells = EllOfWalls();
  const BirdsEyeImage image = MakeReferenceImage(cells, 1);
  for (const double yaw : {0.0, 1.0, M_PI - 0.5, M_PI, 4.0, 6.0}) {
    BirdsEyeCells turned = cells;
    const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).inverse().matrix();
    for (auto& wall : turned.walls) wall = {R * wall.position, R * wall.normal, wall.weight};
    for (auto& free : turned.free) free = R * free;
    turned.radius = 0;
    turned.Enclose();
    const PlanarPose best = BestOf(SearchPlanar(image, turned, {}));
    const PlanarScore score(image, turned, 1);
    EXPECT_LT(std::abs(std::remainder(best.yaw - yaw, 2 * M_PI)), 0.08) << yaw;
    const Eigen::Vector2f moved = R * cells.center;
    EXPECT_LT((best.Apply(moved.cast<double>()) - cells.center.cast<double>()).norm(), 1) << yaw;
    // The transform's score is that of the placement, but for how cells are rounded.
    EXPECT_NEAR(score.Of(best, kAnyScore), best.score, 0.3 * best.score) << yaw;
  }
}

// An early end changes no answer to whether a score is more than the least.
TEST(PlanarScoreTest, EndsEarlyOnlyBelowTheLeast) {
  const BirdsEyeCells cells = EllOfWalls();
  const BirdsEyeImage image = MakeReferenceImage(cells, 1);
  const PlanarScore score(image, cells, 1);
  for (const double x : {-2.0, -0.5, 0.0, 0.5, 3.0}) {
    for (const double yaw : {0.0, 0.3, 1.5, M_PI}) {
      const PlanarPose pose{yaw, {x, 0.5 * x}, 0};
      const double in_full = score.Of(pose, kAnyScore);
      for (const double least : {-20.0, 0.0, in_full - 1e-9, in_full, in_full + 1e-9, 30.0}) {
        if (in_full > least) {
          EXPECT_EQ(score.Of(pose, least), in_full);
        } else {
          EXPECT_LE(score.Of(pose, least), least);
        }
      }
    }
  }
}

}  // namespace
}  // namespace isthmus::matching
