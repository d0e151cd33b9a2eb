#include "server/composition/tiles/detail_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

namespace isthmus::composition {
namespace {

using Place = std::tuple<int32_t, int32_t, int32_t>;

Place PlaceOf(const Voxel& v, uint32_t level) { return {v.x >> level, v.y >> level, v.z >> level}; }

// Different ones, of a flat box around a place.
std::vector<Voxel> RandomVoxels(const Voxel& around, int32_t edge, size_t count, unsigned seed) {
  std::mt19937 rng(seed);
  std::set<Place> taken;
  std::vector<Voxel> voxels;
  while (voxels.size() < count) {
    const auto off = [&](int32_t size) {
      return static_cast<int32_t>(rng() % static_cast<unsigned>(size)) - size / 2;
    };
    const Voxel v{around.x + off(edge), around.y + off(edge), around.z + off(edge / 8 + 1)};
    if (taken.insert(PlaceOf(v, 0)).second) voxels.push_back(v);
  }
  return voxels;
}

void ExpectCoarseToFine(const std::vector<Voxel>& voxels) {
  DetailOrder order;
  order.Sort(voxels);
  std::vector<uint32_t> each = order.order();
  std::sort(each.begin(), each.end());
  std::vector<uint32_t> all(voxels.size());
  std::iota(all.begin(), all.end(), 0);
  ASSERT_EQ(each, all);
  ASSERT_EQ(order.level_size()[0], voxels.size());
  for (uint32_t level = 0; level < kDetailLevels; ++level) {
    std::set<Place> there, in_prefix;
    for (const Voxel& v : voxels) there.insert(PlaceOf(v, level));
    for (uint32_t i = 0; i < order.level_size()[level]; ++i) {
      ASSERT_TRUE(in_prefix.insert(PlaceOf(voxels[order.order()[i]], level)).second)
          << "two in a voxel of level " << level;
    }
    ASSERT_EQ(in_prefix, there) << "level " << level;
  }
}

TEST(DetailOrder, APrefixHasOneOfEachCoarseVoxel) {
  ExpectCoarseToFine({});
  ExpectCoarseToFine({{-1, 5, 3}});
  ExpectCoarseToFine(RandomVoxels({0, 0, 0}, 200, 300, 1));
  ExpectCoarseToFine(RandomVoxels({0, 0, 0}, 200, 20'000, 2));
  ExpectCoarseToFine(RandomVoxels({-1300, 77'700, -40}, 200, 20'000, 3));
  ExpectCoarseToFine(RandomVoxels({0, 0, 0}, 2'000'000, 5000, 4));  // All of the grid.
}

TEST(DetailOrder, DoesNotDependOnWhatCameWhen) {
  std::vector<Voxel> voxels = RandomVoxels({50, -60, 7}, 200, 5000, 5);
  const auto sorted = [](const std::vector<Voxel>& given) {
    DetailOrder order;
    order.Sort(given);
    std::vector<Place> places;
    for (const uint32_t index : order.order()) places.push_back(PlaceOf(given[index], 0));
    return places;
  };
  const std::vector<Place> expected = sorted(voxels);
  std::mt19937 rng(6);
  std::shuffle(voxels.begin(), voxels.end(), rng);
  EXPECT_EQ(sorted(voxels), expected);
}

}  // namespace
}  // namespace isthmus::composition
