// Thins points to one per voxel: the mean of those that fell into it, weighted.
//
// The mean rather than the first point, because a map is made of many looks at the same wall, and
// the mean of n of them has 1/sqrt(n) of their noise. It lies inside its voxel, so that thinning a
// thinned cloud again on the same grid changes nothing but the last digit. Its label is that of
// most of them (Boyer & Moore, "MJRTY - a fast majority vote algorithm", 1981), each with its
// weight and certainty; what the others say takes from the certainty.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/voxel_hash.h"

namespace isthmus::composition {

struct Voxel {
  int32_t x = 0, y = 0, z = 0;
};

// Cubes of one size with a corner at the origin. Value type.
class VoxelGrid {
 public:
  explicit VoxelGrid(double voxel_m) : inverse_(static_cast<float>(1 / voxel_m)) {}

  // Nothing for a point that is not finite or more than 2^20 - 1 voxels from the origin along an
  // axis (105 km at 0.1 m).
  std::optional<Voxel> Find(float x, float y, float z) const {
    constexpr float kLimit = (1 << 20) - 1;
    const float i = x * inverse_, j = y * inverse_, k = z * inverse_;
    // Written so that NaN fails.
    if (!(std::abs(i) < kLimit && std::abs(j) < kLimit && std::abs(k) < kLimit)) return {};
    return Voxel{Floor(i), Floor(j), Floor(k)};
  }
  // True if a coordinate that Find takes lies in a voxel of this index.
  bool IsIn(float value, int32_t index) const { return Floor(value * inverse_) == index; }

 private:
  // std::floor is a library call where the compiler may not assume SSE4.1.
  static int32_t Floor(float value) {
    const int32_t whole = static_cast<int32_t>(value);
    return whole - (static_cast<float>(whole) > value);
  }

  float inverse_;  // Voxels per metre.
};

// A voxel as one number: 21 bits per axis. Different voxels have different keys.
inline uint64_t PackVoxel(const Voxel& v) {
  const auto part = [](int32_t i) { return static_cast<uint64_t>(i + (1 << 20)) & 0x1fffff; };
  return part(v.x) << 42 | part(v.y) << 21 | part(v.z);
}

// A point that stands for `weight` measured ones.
struct WeightedPoint {
  float x = 0, y = 0, z = 0;
  float intensity = 0;
  uint32_t weight = 1;
  // For a submap's points: log odds that something is still there, in steps of kLogOddsStep.
  // other_looks: by other submaps except the ones that looked through before. through_before: by
  // these. own_looks: by the views of the point's own submap. See visibility/.
  int16_t other_looks = 0, through_before = 0;
  int8_t own_looks = 0;
  // The first keyframe that saw it, and how many later the last one is, at most 127.
  uint8_t keyframes_after : 7 = 0;
  bool gone : 1 = false;  // By these looks; see visibility/verdict.h.
  uint16_t keyframe = 0;
  uint8_t label = 0;      // The number of its likeliest PointClass, ...
  uint8_t certainty = 0;  // ... and the probability of that, in 255ths.
};

// An open-addressing hash table from voxel to running mean. Meant to be kept and used again: among
// clouds of like size it allocates nothing. Not thread safe.
class VoxelThinner {
 public:
  VoxelThinner();

  // `stamp` is when it was seen, as MapPoint's.
  void Add(uint64_t voxel, const WeightedPoint& point, uint32_t stamp = 0);
  // Says that a point of the voxel will be added soon. Changes nothing but how long that takes.
  void Prefetch(uint64_t voxel) const { __builtin_prefetch(&slots_[FirstSlot(voxel)]); }
  // Appends one point per voxel, in the order in which voxels were first met, and forgets them.
  void TakePoints(std::vector<WeightedPoint>* out);
  // The same as calls of visit(point, first, stamp): `first` is the first point of the voxel, which
  // lies in it, while rounding may take the mean of many out; `stamp` is the newest.
  template <typename Visit>
  void TakeEach(const Visit& visit) {
    for (const Cell& cell : cells_) visit(Mean(cell), cell.first, cell.stamp);
    Forget();
  }
  size_t size() const { return cells_.size(); }  // Voxels.

 private:
  struct Slot {
    uint64_t key = kNoVoxel;
    uint32_t cell = 0;
  };
  // Sums are kept relative to the first point, where float has digits to spare.
  struct Cell {
    WeightedPoint first;
    float dx = 0, dy = 0, dz = 0, di = 0;
    float votes = 0;  // For the label of `first`, less those for others.
    uint32_t stamp = 0;
  };
  static constexpr uint64_t kNoVoxel = ~uint64_t{0};  // No packed voxel: those have 63 bits.

  static WeightedPoint Mean(const Cell& cell) {
    WeightedPoint p = cell.first;
    const float share = 1 / static_cast<float>(p.weight);
    p.x += cell.dx * share;
    p.y += cell.dy * share;
    p.z += cell.dz * share;
    p.intensity += cell.di * share;
    p.certainty = static_cast<uint8_t>(cell.votes * share);
    return p;
  }
  size_t FirstSlot(uint64_t key) const { return hash_(key) >> shift_; }
  size_t FindSlot(uint64_t key) const;
  void Grow();
  void Shrink();  // When empty.
  void Forget();

  VoxelHash hash_;
  std::vector<Slot> slots_;  // A power of two of them, at most half in use.
  int shift_ = 0;            // 64 - log2(slots_.size()).
  std::vector<Cell> cells_;
  int roomy_in_a_row_ = 0;  // Clouds for which the table was far too large.
};

}  // namespace isthmus::composition
