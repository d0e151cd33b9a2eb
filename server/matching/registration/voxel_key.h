// Voxel indices packed in 64 bits, for hashing.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace isthmus::matching {

// 21 bits per axis; unique while every coordinate is within +-2^20 voxels.
inline uint64_t VoxelKey(const Eigen::Vector3f& p, float inverse_voxel) {
  const auto pack = [&](float v) {
    return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v * inverse_voxel)) + (1 << 20)) &
           0x1fffff;
  };
  return pack(p.x()) | pack(p.y()) << 21 | pack(p.z()) << 42;
}

// The same of a square of the ground plane, 32 bits per axis.
inline uint64_t CellKey(double x, double y, double inverse_cell) {
  const auto column = static_cast<int32_t>(std::floor(x * inverse_cell));
  const auto row = static_cast<int32_t>(std::floor(y * inverse_cell));
  return static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
}

}  // namespace isthmus::matching
