#include "core/geometry/voxel_thinner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geometry/voxel_hash.h"
#include "core/stopwatch.h"

namespace isthmus {
namespace {

// 0.1 m, so a block is 0.4 m wide; this one is 2499 or less along each axis.
using BlockOfVoxels = std::array<uint32_t, 3>;
constexpr float kThinVoxelM = 0.1F;

double MsToThin(const std::vector<BlockOfVoxels>& blocks) {
  VoxelThinner thinner(kThinVoxelM);
  const auto centre = [](uint32_t block) {
    return (4.F * static_cast<float>(block) + 2) * kThinVoxelM - 500;
  };
  double ms = 0;
  for (int round = 0; round < 2; ++round) {  // The second finds a table that is large enough.
    thinner.Clear();
    const Stopwatch watch;
    for (const auto& [i, j, k] : blocks) thinner.Insert(centre(i), centre(j), centre(k));
    ms = watch.Ms();
  }
  EXPECT_EQ(thinner.size(), blocks.size());
  return ms;
}

// One point of each block, which share a slot where the multiplier is known.
TEST(VoxelThinner, PointsChosenToCollideCostNoMoreThanOthers) {
  constexpr uint64_t kKnownMultiplier = 0x9e3779b97f4a7c15u;
  constexpr uint64_t kSlots = 1 << 13, kFirstEpoch = uint64_t{1} << 36;
  std::vector<BlockOfVoxels> chosen, any;
  for (uint32_t i = 0; chosen.size() < 4000; ++i) {
    for (uint32_t j = 0; j < 2500; ++j) {
      for (uint32_t k = 0; k < 2500 && chosen.size() < 4000; ++k) {
        const uint64_t block = uint64_t{i} << 24 | uint64_t{j} << 12 | k;
        const uint64_t product = (block | kFirstEpoch) * kKnownMultiplier;
        if ((product >> 40) % kSlots == 0) chosen.push_back({i, j, k});
      }
    }
  }
  std::mt19937 rng(1);
  for (uint32_t i = 0; i < chosen.size(); ++i) {
    any.push_back({i % 2500, static_cast<uint32_t>(rng()) % 2500, i / 2500});
  }
  double chosen_ms = 1e9, any_ms = 1e9;
  for (int i = 0; i < 3; ++i) {
    chosen_ms = std::min(chosen_ms, MsToThin(chosen));
    any_ms = std::min(any_ms, MsToThin(any));
  }
  EXPECT_LT(chosen_ms, 10 * any_ms);  // It was some hundred times as much.
}

TEST(VoxelHash, OfAProcessIsOneAndOthersDiffer) {
  EXPECT_EQ(VoxelHash()(7), VoxelHash()(7));
  EXPECT_NE(VoxelHash(1, 3)(7), VoxelHash(1, 5)(7));
  EXPECT_NE(VoxelHash(1, 3)(7), VoxelHash(2, 3)(7));
}

}  // namespace
}  // namespace isthmus
