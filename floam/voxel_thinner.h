// One point per voxel of a single scan, at a few nanoseconds per point.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace isthmus::floam {

// A set of voxels that is emptied in constant time. Not thread safe.
class VoxelThinner {
 public:
  // Takes coordinates within +-500 m.
  explicit VoxelThinner(float voxel_m)
      : inverse_voxel_(1 / voxel_m), offset_(500.F / voxel_m), slots_(size_t{1} << 12, 0) {}

  void Clear() {
    ++epoch_;
    size_ = 0;
    last_ = kNone;
  }

  // True for the first point of its voxel since Clear.
  bool Insert(float x, float y, float z) {
    const uint64_t key = Cell(x) << 28 | Cell(y) << 14 | Cell(z);
    if (key == last_) return false;  // Neighbours on a ring mostly share their voxel.
    last_ = key;
    if (2 * size_ >= slots_.size()) Grow();
    return Place(key | epoch_ << 42);
  }

  size_t size() const { return size_; }

 private:
  static constexpr uint64_t kNone = ~uint64_t{0};

  uint64_t Cell(float v) const {
    return static_cast<uint64_t>(static_cast<int32_t>(v * inverse_voxel_ + offset_)) & 0x3fff;
  }
  bool Place(uint64_t tagged) {
    const size_t mask = slots_.size() - 1;
    size_t slot = (tagged * 0x9e3779b97f4a7c15ULL) >> 40 & mask;
    while (slots_[slot] >> 42 == (epoch_ & 0x3fffff)) {
      if (slots_[slot] == tagged) return false;
      slot = (slot + 1) & mask;
    }
    slots_[slot] = tagged;
    ++size_;
    return true;
  }
  void Grow() {
    std::vector<uint64_t> old(slots_.size() * 4, 0);
    old.swap(slots_);
    size_ = 0;
    for (const uint64_t tagged : old) {
      if (tagged >> 42 == (epoch_ & 0x3fffff)) Place(tagged);
    }
  }

  float inverse_voxel_;
  float offset_;
  std::vector<uint64_t> slots_;  // Voxel and, in the top bits, the epoch it was put in.
  uint64_t epoch_ = 1;
  size_t size_ = 0;
  uint64_t last_ = kNone;
};

}  // namespace isthmus::floam
