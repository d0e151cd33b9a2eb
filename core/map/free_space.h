// The space of a map that rays found free or occupied.
#pragma once

#include <cstdint>
#include <vector>

namespace isthmus {

// A cube of voxels that are all free, or all occupied. Voxels are counted from the origin of the
// map: voxel 0 begins there.
struct VoxelCube {
  int32_t x = 0, y = 0, z = 0;  // Its lowest voxel.
  int32_t edge = 1;             // Voxels along each side; a power of two.
  bool is_occupied = false;
};

struct FreeSpace {
  double resolution_m = 0;  // Edge of a voxel.
  std::vector<VoxelCube> cubes = {};
};

}  // namespace isthmus
