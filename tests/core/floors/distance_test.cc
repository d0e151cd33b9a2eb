// Distances from what is not open, against all pairs of cells.
#include "core/floors/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace isthmus::floors {
namespace {

int64_t SlowSquare(const Mask& mask, const Cell& at) {
  int64_t least = 1'000'000;
  for (int64_t y = -1; y <= mask.height; ++y) {
    for (int64_t x = -1; x <= mask.width; ++x) {
      const bool is_open = mask.Has(x, y) ? mask.IsOpen(x, y) : mask.is_open_beyond;
      if (is_open) continue;
      least = std::min(least, (x - at.x) * (x - at.x) + (y - at.y) * (y - at.y));
    }
  }
  return least;
}

TEST(Distance, IsThatOfTheNearestCell) {
  std::mt19937 random(1);
  for (const bool is_open_beyond : {false, true}) {
    for (const uint32_t one_in : {3u, 20u, 200u}) {
      Mask mask{37, 23, {}, is_open_beyond};
      for (int64_t i = 0; i < mask.width * mask.height; ++i) {
        mask.open.push_back(i != 100 && random() % one_in != 0 ? 1 : 0);
      }
      const std::vector<int32_t> squares = SquaredDistances(mask);
      for (size_t i = 0; i < squares.size(); ++i) {
        ASSERT_EQ(squares[i], SlowSquare(mask, mask.At(i))) << i << " of one in " << one_in;
      }
    }
  }
}

TEST(Distance, IsLargeWhereNothingIsClosed) {
  const Mask mask{5, 4, std::vector<uint8_t>(20, 1), true};
  for (const int32_t square : SquaredDistances(mask)) EXPECT_GT(square, 1'000'000);
}

}  // namespace
}  // namespace isthmus::floors
