#include "core/codec/tile_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace isthmus::codec {
namespace {

std::vector<MapPoint> RandomTile(int count) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> place(100, 120), height(-3, 9), intensity(-20, 300);
  std::vector<MapPoint> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(
        {place(rng), -place(rng), height(rng), intensity(rng), static_cast<uint32_t>(rng() % 300),
         static_cast<PointClass>(rng() % kPointClasses), static_cast<uint32_t>(rng())});
  }
  return points;
}

TEST(TilePointsTest, PointsComeBackToAFractionOfAMillimetre) {
  const std::vector<MapPoint> points = RandomTile(5000);
  const auto read = ReadTilePoints(WriteTilePoints(points));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const MapPoint &p = points[i], &q = (*read)[i];
    ASSERT_NEAR(p.x, q.x, 2e-4);
    ASSERT_NEAR(p.y, q.y, 2e-4);
    ASSERT_NEAR(p.z, q.z, 2e-4);
    ASSERT_EQ(q.intensity, std::round(std::clamp(p.intensity, 0.F, 255.F)));
    ASSERT_EQ(q.robot, std::min(p.robot, 255u));
    ASSERT_EQ(q.stamp, p.stamp);
    ASSERT_EQ(q.label, p.label);
  }
}

// As other programs read it, byte by byte.
TEST(TilePointsTest, TheLayoutIsAsTheDocumentSays) {
  const std::string bytes = WriteTilePoints(
      {{1, 2, 3, 7, 1, PointClass::kWall, 0x04030201}, {2, 2, 3, 8, 0, PointClass::kMover, 5}});
  ASSERT_EQ(bytes.size(), 56u + 2 * 13);
  EXPECT_EQ(bytes.substr(0, 8), std::string("PTS2\x02\0\0\0", 8));
  double origin[3], scale[3];
  std::memcpy(origin, bytes.data() + 8, sizeof(origin));
  std::memcpy(scale, bytes.data() + 32, sizeof(scale));
  EXPECT_EQ(origin[0], 1);
  EXPECT_EQ(origin[2], 3);
  EXPECT_EQ(scale[0], 1 / 65535.0);
  EXPECT_EQ(scale[1], 0);
  EXPECT_EQ(bytes.substr(56, 12), std::string("\0\0\0\0\0\0\xff\xff\0\0\0\0", 12));
  EXPECT_EQ(bytes.substr(68, 4), std::string("\x07\x08\x01\x00", 4));
  EXPECT_EQ(bytes.substr(72, 8), std::string("\x01\x02\x03\x04\x05\0\0\0", 8));
  EXPECT_EQ(bytes.substr(80), "\x03\x09");
}

TEST(TilePointsTest, NoneAndOneAreTilesToo) {
  EXPECT_TRUE(ReadTilePoints(WriteTilePoints({}))->empty());
  const auto one = ReadTilePoints(WriteTilePoints({{1, 2, 3, std::nanf("")}}));
  ASSERT_EQ(one->size(), 1u);
  EXPECT_EQ(one->front().x, 1);
  EXPECT_EQ(one->front().intensity, 0);
}

TEST(TilePointsTest, DamagedBytesAreNoPoints) {
  const std::string bytes = WriteTilePoints(RandomTile(10));
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_FALSE(ReadTilePoints(absl::string_view(bytes).substr(0, size)).ok());
  }
  EXPECT_FALSE(ReadTilePoints(bytes + "x").ok());
  std::string other = bytes;
  other[3] = '1';
  EXPECT_FALSE(ReadTilePoints(other).ok());
  std::string huge = bytes;
  huge[7] = '\xff';  // A count that is not there.
  EXPECT_FALSE(ReadTilePoints(huge).ok());
}

}  // namespace
}  // namespace isthmus::codec
