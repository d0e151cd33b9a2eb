// The log-odds of a column's voxels while rays are cast into it: blocks of voxels where any was
// seen.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/composition/occupancy/column_key.h"

namespace isthmus::composition {

struct VoxelCell {
  float log_odds = 0;
  uint32_t scan = 0;  // The last one that changed it, so that each does so once; 0: never seen.
};

// 8 x 8 x 8 voxels: 4 kB, a page.
inline constexpr int kBlockBits = 3;                // Layout
inline constexpr int kBlockEdge = 1 << kBlockBits;  // Layout
// Blocks across a column.
inline constexpr int kBlocksAcross = kColumnEdge / kBlockEdge;  // Layout

using VoxelBlock = std::array<VoxelCell, kBlockEdge * kBlockEdge * kBlockEdge>;

// x is the fastest.
inline int CellInBlock(int32_t x, int32_t y, int32_t z) {
  constexpr int kMask = kBlockEdge - 1;
  return (x & kMask) | (y & kMask) << kBlockBits | (z & kMask) << 2 * kBlockBits;
}

// Not thread safe.
class VoxelColumn {
 public:
  // x and y may count from anywhere that is a whole number of columns away.
  VoxelCell& At(const VoxelIndex& index) {
    const auto layer = static_cast<size_t>((index.z() >> kBlockBits) - bottom_);
    if (layer >= layers_.size() || layers_[layer] == nullptr) return Make(index);
    VoxelBlock* block = (*layers_[layer])[InLayer(index)].get();
    return block == nullptr ? Make(index) : (*block)[CellInBlock(index.x(), index.y(), index.z())];
  }
  // Null where nothing was seen; z counts blocks, from 0 at the origin.
  const VoxelBlock* BlockAt(int32_t x, int32_t y, int32_t block_z) const {
    const auto layer = static_cast<size_t>(block_z - bottom_);
    if (layer >= layers_.size() || layers_[layer] == nullptr) return nullptr;
    return (*layers_[layer])[InLayer({x, y, 0})].get();
  }
  // Null where the voxel's block is.
  const VoxelCell* Find(const VoxelIndex& index) const {
    const VoxelBlock* block = BlockAt(index.x(), index.y(), index.z() >> kBlockBits);
    return block == nullptr ? nullptr : &(*block)[CellInBlock(index.x(), index.y(), index.z())];
  }

  // Blocks from `bottom` to below `top`, counted as in BlockAt, hold all there is.
  int32_t bottom() const { return bottom_; }
  int32_t top() const { return bottom_ + static_cast<int32_t>(layers_.size()); }
  uint64_t bytes() const { return bytes_; }

 private:
  using Layer = std::array<std::unique_ptr<VoxelBlock>, kBlocksAcross * kBlocksAcross>;

  static size_t InLayer(const VoxelIndex& index) {
    constexpr int kMask = kBlocksAcross - 1;
    return static_cast<size_t>((index.x() >> kBlockBits & kMask) | (index.y() >> kBlockBits & kMask)
                                                                       << kBlockBits);
  }
  VoxelCell& Make(const VoxelIndex& index);

  int32_t bottom_ = 0;
  std::vector<std::unique_ptr<Layer>> layers_;  // From the bottom; blocks with x fastest.
  uint64_t bytes_ = 0;
};

}  // namespace isthmus::composition
