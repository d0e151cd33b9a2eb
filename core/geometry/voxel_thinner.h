// One point per voxel of a single scan, at a few nanoseconds per point.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/voxel_hash.h"

namespace isthmus {

// A set of voxels that is emptied in constant time. Kept as one bit per voxel of blocks of 4 x 4 x
// 4, which neighbours on a ring mostly share: few places in memory are looked at. Not thread safe.
class VoxelThinner {
 public:
  // Takes coordinates within +-500 m.
  explicit VoxelThinner(float voxel_m)
      : inverse_voxel_(1 / voxel_m), offset_(500.F / voxel_m), slots_(size_t{1} << 11) {}

  void Clear() {
    ++epoch_;
    size_ = blocks_ = 0;
    last_ = kNone;
  }

  // True for the first point of its voxel since Clear.
  bool Insert(float x, float y, float z) {
    const uint64_t i = Cell(x), j = Cell(y), k = Cell(z);
    const uint64_t block = (i >> 2) << 24 | (j >> 2) << 12 | k >> 2;
    if (block != last_) {
      if (2 * blocks_ >= slots_.size()) Grow();
      last_ = block;
      last_slot_ = FindSlot(block | epoch_ << 36);
    }
    uint64_t& voxels = slots_[last_slot_].voxels;
    const uint64_t voxel = uint64_t{1} << ((i & 3) << 4 | (j & 3) << 2 | (k & 3));
    if ((voxels & voxel) != 0) return false;
    voxels |= voxel;
    ++size_;
    return true;
  }

  size_t size() const { return size_; }

 private:
  struct Slot {
    uint64_t tag = 0;  // The block and, in the top bits, the epoch it was put in.
    uint64_t voxels = 0;
  };
  static constexpr uint64_t kNone = ~uint64_t{0};
  static constexpr uint64_t kEpochs = 0xfffffff;

  uint64_t Cell(float v) const {
    return static_cast<uint64_t>(static_cast<int32_t>(v * inverse_voxel_ + offset_)) & 0x3fff;
  }
  bool IsCurrent(const Slot& slot) const { return slot.tag >> 36 == (epoch_ & kEpochs); }
  // The slot of the block, which is put in if it is not there.
  size_t FindSlot(uint64_t tag) {
    const size_t mask = slots_.size() - 1;
    size_t at = hash_(tag) & mask;
    while (IsCurrent(slots_[at])) {
      if (slots_[at].tag == tag) return at;
      at = (at + 1) & mask;
    }
    slots_[at] = {tag, 0};
    ++blocks_;
    return at;
  }
  void Grow() {
    std::vector<Slot> old(slots_.size() * 4);
    old.swap(slots_);
    blocks_ = 0;
    for (const Slot& slot : old) {
      if (IsCurrent(slot)) slots_[FindSlot(slot.tag)].voxels = slot.voxels;
    }
  }

  VoxelHash hash_;
  float inverse_voxel_;
  float offset_;
  std::vector<Slot> slots_;
  uint64_t epoch_ = 1;
  size_t size_ = 0, blocks_ = 0;
  uint64_t last_ = kNone;  // The block looked at last, and where it is.
  size_t last_slot_ = 0;
};

}  // namespace isthmus
