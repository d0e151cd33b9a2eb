#include "server/composition/voxel_thinner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "core/stopwatch.h"
#include "server/composition/tiles/tile_layout.h"

namespace isthmus::composition {
namespace {

TEST(VoxelGrid, FloorsOnBothSidesOfZero) {
  const VoxelGrid grid(0.5);
  const auto voxel = grid.Find(-0.25f, 0.25f, -0.5f);
  ASSERT_TRUE(voxel.has_value());
  EXPECT_EQ(voxel->x, -1);
  EXPECT_EQ(voxel->y, 0);
  EXPECT_EQ(voxel->z, -1);
}

TEST(VoxelGrid, RefusesWhatItCannotNumber) {
  const VoxelGrid grid(0.1);
  EXPECT_FALSE(grid.Find(std::numeric_limits<float>::quiet_NaN(), 0, 0));
  EXPECT_FALSE(grid.Find(0, std::numeric_limits<float>::infinity(), 0));
  EXPECT_FALSE(grid.Find(0, 0, -2e5f));
  EXPECT_TRUE(grid.Find(1e5f, -1e5f, 1e5f));
}

TEST(PackVoxel, KeysDiffer) {
  std::set<uint64_t> keys;
  const int32_t limit = (1 << 20) - 2;
  for (const int32_t x : {-limit, -1, 0, 1, limit}) {
    for (const int32_t y : {-limit, -1, 0, 1, limit}) {
      for (const int32_t z : {-limit, -1, 0, 1, limit}) keys.insert(PackVoxel({x, y, z}));
    }
  }
  EXPECT_EQ(keys.size(), 125u);
}

WeightedPoint Labelled(uint8_t label, uint8_t certainty, uint32_t weight) {
  WeightedPoint point;
  point.label = label;
  point.certainty = certainty;
  point.weight = weight;
  return point;
}

// One voxel's label and certainty.
std::pair<int, int> Vote(const std::vector<WeightedPoint>& points) {
  VoxelThinner thinner;
  for (const WeightedPoint& point : points) thinner.Add(7, point);
  std::vector<WeightedPoint> out;
  thinner.TakePoints(&out);
  return {out.front().label, out.front().certainty};
}

TEST(VoxelThinner, PointsOfAVoxelVoteOnItsLabel) {
  EXPECT_EQ(Vote({Labelled(3, 200, 1)}), std::pair(3, 200));
  EXPECT_EQ(Vote({Labelled(3, 200, 1), Labelled(3, 100, 1)}), std::pair(3, 150));
  // Weight and certainty count; who is outvoted takes from the certainty.
  EXPECT_EQ(Vote({Labelled(3, 200, 1), Labelled(5, 100, 1)}), std::pair(3, 50));
  EXPECT_EQ(Vote({Labelled(3, 200, 1), Labelled(5, 150, 3)}), std::pair(5, 62));
  EXPECT_EQ(Vote({Labelled(5, 150, 3), Labelled(3, 200, 1)}), std::pair(5, 62));
  EXPECT_EQ(Vote({WeightedPoint()}), std::pair(0, 0));
}

TEST(TileLayout, CutsAtWholeVoxels) {
  const TileLayout layout(1, 0.1);  // 10 voxels.
  EXPECT_EQ(layout.Find(3, {0, 9, 0}), (TileKey{3, 0, 0}));
  EXPECT_EQ(layout.Find(3, {10, -1, 99}), (TileKey{3, 1, -1}));
  EXPECT_EQ(layout.Find(3, {-10, -11, 0}), (TileKey{3, -1, -2}));
  const TileLayout odd(0.7, 0.1);
  for (int32_t i = -(1 << 20) + 1; i < (1 << 20); i += 3) {
    ASSERT_EQ(odd.Find(0, {i, 0, 0}).x, static_cast<int32_t>(std::floor(i / 7.))) << i;
  }
}

TEST(VoxelThinner, MeansMatchAPlainMap) {
  std::mt19937 rng(5);
  std::normal_distribution<float> spread(500, 3);
  const VoxelGrid grid(0.5);
  VoxelThinner thinner;
  for (int round = 0; round < 3; ++round) {  // The same thinner again: nothing may be left over.
    struct Sum {
      double x = 0, intensity = 0, weight = 0;
    };
    std::map<uint64_t, Sum> sums;
    for (int i = 0; i < 30000; ++i) {
      const WeightedPoint p{spread(rng), spread(rng), spread(rng), float(rng() % 256),
                            uint32_t(1 + rng() % 9)};
      const uint64_t key = PackVoxel(*grid.Find(p.x, p.y, p.z));
      thinner.Add(key, p);
      Sum& sum = sums[key];
      sum.x += double(p.weight) * p.x;
      sum.intensity += double(p.weight) * p.intensity;
      sum.weight += p.weight;
    }
    std::vector<WeightedPoint> thinned;
    thinner.TakePoints(&thinned);
    ASSERT_EQ(thinned.size(), sums.size());
    double weight = 0;
    for (const WeightedPoint& p : thinned) {
      const Sum& sum = sums.at(PackVoxel(*grid.Find(p.x, p.y, p.z)));
      EXPECT_NEAR(p.x, sum.x / sum.weight, 1e-4);
      EXPECT_NEAR(p.intensity, sum.intensity / sum.weight, 1e-2);
      weight += p.weight;
      EXPECT_EQ(p.weight, sum.weight);
    }
    EXPECT_GT(weight, 30000);
  }
}

TEST(VoxelThinner, WhatItThinnedBeforeShowsInNothing) {
  std::mt19937 rng(6);
  VoxelThinner thinner;
  std::vector<int> sizes{100'000, 10, 3000};
  for (int i = 0; i < 50; ++i) sizes.push_back(i % 7);  // Its table shrinks.
  for (const int size : {3000, 1, 40'000}) sizes.push_back(size);
  for (const int size : sizes) {
    VoxelThinner fresh;
    for (int i = 0; i < size; ++i) {
      const WeightedPoint p{float(rng() % 1000), float(rng() % 1000), 0, 0, 1};
      const uint64_t key = rng() % (size + 1);
      thinner.Add(key, p);
      fresh.Add(key, p);
    }
    std::vector<WeightedPoint> thinned, expected;
    thinner.TakePoints(&thinned);
    fresh.TakePoints(&expected);
    ASSERT_EQ(thinned.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(thinned[i].x, expected[i].x);
      ASSERT_EQ(thinned[i].weight, expected[i].weight);
    }
  }
}

// The table of a cloud of millions would be cleared for every small one, which takes minutes.
TEST(VoxelThinner, SmallCloudsAreQuickAfterALargeOne) {
  VoxelThinner thinner;
  std::vector<WeightedPoint> thinned;
  for (uint64_t i = 0; i < 1'000'000; ++i) thinner.Add(i, {});
  thinner.TakePoints(&thinned);
  Stopwatch watch;
  for (uint64_t i = 0; i < 10'000; ++i) {
    thinned.clear();
    thinner.Add(i, {});
    thinner.TakePoints(&thinned);
  }
  EXPECT_LT(watch.Ms(), 3000);
}

double MsToAdd(const std::vector<uint64_t>& voxels) {
  VoxelThinner thinner;
  const Stopwatch watch;
  for (const uint64_t voxel : voxels) thinner.Add(voxel, {});
  return watch.Ms();
}

// Every multiplicative hash with a known, odd multiplier can be undone: these products have
// nothing in the bits that a table would go by.
TEST(VoxelThinner, VoxelsChosenToCollideCostNoMoreThanOthers) {
  constexpr uint64_t kKnownMultiplier = 0x9e3779b97f4a7c15u;
  uint64_t inverse = kKnownMultiplier;  // Right in 3 bits, then in twice as many each time.
  for (int i = 0; i < 5; ++i) inverse *= 2 - kKnownMultiplier * inverse;
  ASSERT_EQ(inverse * kKnownMultiplier, 1u);
  std::vector<uint64_t> chosen, any;
  std::mt19937_64 rng(7);
  for (uint64_t i = 1; chosen.size() < 40'000; ++i) {
    if (const uint64_t voxel = inverse * i; voxel >> 63 == 0) chosen.push_back(voxel);
  }
  while (any.size() < chosen.size()) any.push_back(rng() >> 1);
  double chosen_ms = 1e9, any_ms = 1e9;
  for (int i = 0; i < 3; ++i) {
    chosen_ms = std::min(chosen_ms, MsToAdd(chosen));
    any_ms = std::min(any_ms, MsToAdd(any));
  }
  EXPECT_LT(chosen_ms, 10 * any_ms);  // It was some hundred times as much.
}

}  // namespace
}  // namespace isthmus::composition
