// OctoMap's binary files (.bt), read without OctoMap.
// Hornung et al., "OctoMap", Autonomous Robots 2013, section 5: two bits for each of eight
// children.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

namespace isthmus::formats {

// A cube of voxels that are all free, or all occupied. Voxels are counted from the origin of the
// map: voxel 0 begins there.
struct OctomapLeaf {
  int32_t x = 0, y = 0, z = 0;  // Its lowest voxel.
  int32_t edge = 1;             // Voxels along each side; a power of two.
  bool is_occupied = false;
};

// Calls `visit` for every leaf, in the order of the file, and returns the edge of a voxel in
// metres. InvalidArgument, naming what is wrong, for bytes that are none of that format or end
// early.
absl::StatusOr<double> ParseOctomapBinary(const std::string& bytes,
                                          const std::function<void(const OctomapLeaf&)>& visit);

}  // namespace isthmus::formats
