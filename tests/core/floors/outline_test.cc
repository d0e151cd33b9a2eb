// Outlines of labelled cells.
#include "core/floors/outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "core/floors/simplify.h"

namespace isthmus::floors {
namespace {

// Digits are labels; the first row is the lowest.
std::vector<std::vector<Outline>> Trace(const std::vector<std::string>& rows, size_t count) {
  Mask ground{static_cast<int64_t>(rows[0].size()), static_cast<int64_t>(rows.size()), {}};
  std::vector<int32_t> labels;
  for (const std::string& row : rows) {
    for (const char c : row) labels.push_back(c == '.' ? -1 : c - '0');
  }
  return OutlinesOf(ground, labels, count);
}

double SumOfAreas(const std::vector<Outline>& outlines) {
  double sum = 0;
  for (const Outline& outline : outlines) sum += SignedArea(outline);
  return sum;
}

TEST(Outline, OfARectangleHasItsCorners) {
  const auto outlines = Trace({"......", ".0000.", ".0000.", ".0000.", "......"}, 1);
  ASSERT_EQ(outlines[0].size(), 1u);
  EXPECT_EQ(outlines[0][0].size(), 4u);
  EXPECT_EQ(SignedArea(outlines[0][0]), 12);
}

TEST(Outline, HolesTurnTheOtherWay) {
  std::vector<std::string> rows(20, std::string(20, '0'));
  for (size_t y = 6; y < 14; ++y) rows[y].replace(5, 10, 10, '1');
  const auto outlines = Trace(rows, 2);
  ASSERT_EQ(outlines[0].size(), 2u);
  EXPECT_EQ(SignedArea(outlines[0][0]), 400);
  EXPECT_EQ(SignedArea(outlines[0][1]), -80);
  ASSERT_EQ(outlines[1].size(), 1u);
  EXPECT_EQ(SignedArea(outlines[1][0]), 80);
}

// Outlines of walks at random meet neither themselves nor each other.
TEST(Outline, NeverCrosses) {
  for (uint32_t seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::vector<std::string> rows(24, std::string(24, '.'));
    size_t x = 12, y = 12, cells = 0;
    for (int i = 0; i < 250; ++i) {
      cells += rows[y][x] == '.' ? 1 : 0;
      rows[y][x] = '0';
      const uint32_t way = random() % 4;
      if (way == 0 && x < 23) ++x;
      if (way == 1 && x > 0) --x;
      if (way == 2 && y < 23) ++y;
      if (way == 3 && y > 0) --y;
    }
    const auto outlines = Trace(rows, 1);
    EXPECT_FALSE(Cross(outlines[0])) << seed;
    ASSERT_FALSE(outlines[0].empty());
    EXPECT_GT(SignedArea(outlines[0][0]), 0);
    for (size_t i = 1; i < outlines[0].size(); ++i) EXPECT_LT(SignedArea(outlines[0][i]), 0);
    EXPECT_NEAR(SumOfAreas(outlines[0]), static_cast<double>(cells),
                0.7 * static_cast<double>(cells));
  }
}

}  // namespace
}  // namespace isthmus::floors
