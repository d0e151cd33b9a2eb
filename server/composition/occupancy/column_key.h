// The division of a component's plane into square columns of voxels, on which occupancy is kept.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <utility>

namespace isthmus::composition {

// Levels of an OctoMap: so many bits tell voxels apart per axis, the origin in the middle.
inline constexpr int kTreeDepth = 16;  // Format

using VoxelIndex = Eigen::Matrix<int32_t, 3, 1>;  // Voxels from the origin.

// Voxels along an edge: 64. A cube of so many is a whole branch of an octree, 6 levels deep.
inline constexpr int kColumnBits = 6;                     // Layout
inline constexpr int32_t kColumnEdge = 1 << kColumnBits;  // Layout

struct ColumnKey {
  int32_t x = 0, y = 0;

  friend auto operator<=>(const ColumnKey&, const ColumnKey&) = default;
  friend bool operator==(const ColumnKey&, const ColumnKey&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const ColumnKey& key) {
    return H::combine(std::move(h), key.x, key.y);
  }
};

// Shifting a negative number rounds down, as it must here.
inline ColumnKey ColumnOf(const VoxelIndex& index) {
  return {index.x() >> kColumnBits, index.y() >> kColumnBits};
}

}  // namespace isthmus::composition
