#include "core/geometry/range_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace isthmus {
namespace {

RangeImage Wall(float distance, float from_azimuth, float to_azimuth) {
  std::vector<Eigen::Vector3f> points;
  for (float azimuth = from_azimuth; azimuth < to_azimuth; azimuth += 0.01f) {
    for (float elevation = -0.2f; elevation <= 0.2f; elevation += 0.03f) {
      points.push_back(distance * Eigen::Vector3f(std::cos(elevation) * std::cos(azimuth),
                                                  std::cos(elevation) * std::sin(azimuth),
                                                  std::sin(elevation)));
    }
  }
  return RangeImage(points);
}

TEST(RangeImageTest, GivesTheMeasuredRange) {
  const RangeImage image = Wall(7.5f, -3.1f, 3.1f);
  RangeImage::Interval seen;
  for (const float azimuth : {-2.9f, -1.0f, 0.0f, 0.4f, 1.9f}) {
    ASSERT_TRUE(image.At({std::cos(azimuth), std::sin(azimuth), 0.05f}, &seen)) << azimuth;
    EXPECT_NEAR(seen.shortest, 7.5f, 0.02f);
    EXPECT_NEAR(seen.longest, 7.5f, 0.02f);
  }
}

TEST(RangeImageTest, SaysNothingWhereNothingWasMeasured) {
  const RangeImage image = Wall(7.5f, -0.5f, 0.5f);
  RangeImage::Interval seen;
  EXPECT_FALSE(image.At({-1, 0, 0}, &seen));
  EXPECT_FALSE(image.At({1, 0, 0.6f}, &seen));
  EXPECT_FALSE(image.At({0, 0, 1}, &seen));  // Straight up: outside of the rows.
  EXPECT_FALSE(RangeImage().At({1, 0, 0}, &seen));
  EXPECT_FALSE(RangeImage(std::vector<Eigen::Vector3f>()).At({1, 0, 0}, &seen));
}

TEST(RangeImageTest, ClaimsNoMoreThanBothSidesOfAnEdge) {
  std::vector<Eigen::Vector3f> points;
  for (int i = -60; i < 60; ++i) {
    const float azimuth = 0.005f * (static_cast<float>(i) + 0.5f);
    const float range = i < 0 ? 4.0f : 9.0f;
    points.push_back(range * Eigen::Vector3f(std::cos(azimuth), std::sin(azimuth), 0.001f));
  }
  const RangeImage image(points);
  RangeImage::Interval seen;
  ASSERT_TRUE(image.At({std::cos(0.02f), std::sin(0.02f), 0.001f}, &seen));
  EXPECT_NEAR(seen.shortest, 4.0f, 0.02f);
  EXPECT_NEAR(seen.longest, 9.0f, 0.02f);
  ASSERT_TRUE(image.At({std::cos(0.2f), std::sin(0.2f), 0.001f}, &seen));
  EXPECT_NEAR(seen.shortest, 9.0f, 0.02f);
}

}  // namespace
}  // namespace isthmus
