// The evidence of a column as it is kept: the pruned branches of an octree, some byte per leaf.
#pragma once

#include <cstdint>
#include <vector>

#include "server/composition/occupancy/column_key.h"
#include "server/composition/occupancy/voxel_column.h"

namespace isthmus::composition {

inline constexpr int kChildren = 8;  // Format

// The kind of a node's child.
enum class Branch : uint8_t { kUnknown = 0, kLeaf = 1, kInner = 3 };

// Equal log-odds give equal bytes, in whatever order voxels were seen. Immutable.
//
// A column is cut into cubes as high as it is wide, from the lowest that is not empty. A cube is a
// Branch in a byte, followed by its content. That of a leaf, all voxels alike, is which of the
// levels, seven bits to a byte, the lowest first, with the eighth set in all but the last. That of
// an inner node is two bits for each of eight children, the first lowest, x the fastest, then the
// content of one child after the other. There is no inner node whose children are equal leaves.
class PackedColumn {
 public:
  struct Cube {
    int32_t z = 0;       // Counted in cubes, 0 begins at the origin.
    uint32_t begin = 0;  // Index of its first byte.
  };

  explicit PackedColumn(const VoxelColumn& column);

  // Into an empty column, with `scan` as what saw it.
  void Unpack(uint32_t scan, VoxelColumn* column) const;
  // One cube alone.
  void Unpack(const Cube& cube, uint32_t scan, VoxelColumn* column) const;

  const std::vector<Cube>& cubes() const { return cubes_; }
  const std::vector<float>& levels() const { return levels_; }  // Log-odds that occur.
  const uint8_t* BytesOf(const Cube& cube) const { return bytes_.data() + cube.begin; }

  uint64_t bytes() const {  // In memory, about.
    return bytes_.capacity() + levels_.capacity() * sizeof(float) +
           cubes_.capacity() * sizeof(Cube) + sizeof(PackedColumn);
  }

 private:
  std::vector<Cube> cubes_;
  std::vector<float> levels_;
  std::vector<uint8_t> bytes_;
};

// Reads the index of a leaf's level, and goes on behind it.
inline uint32_t TakeLevel(const uint8_t** at) {
  uint32_t level = **at & 0x7f;
  for (int shift = 7; *(*at)++ & 0x80; shift += 7) level |= uint32_t{**at & 0x7fu} << shift;
  return level;
}
// Reads the children of an inner node, two bits each, and goes on behind them.
inline uint32_t TakeChildren(const uint8_t** at) {
  const uint32_t children = (*at)[0] | uint32_t{(*at)[1]} << 8;
  *at += 2;
  return children;
}
inline Branch ChildOf(uint32_t children, int child) {
  return static_cast<Branch>(children >> 2 * child & 3);
}

}  // namespace isthmus::composition
