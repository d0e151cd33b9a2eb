// OctoMap's binary files (.bt), read without OctoMap.
// Hornung et al., "OctoMap", Autonomous Robots 2013, section 5: two bits for each of eight
// children.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <string>

#include "core/map/free_space.h"

namespace isthmus::formats {

// Calls `visit` for every leaf, in the order of the file, and returns the edge of a voxel in
// metres. InvalidArgument, naming what is wrong, for bytes that are none of that format or end
// early.
absl::StatusOr<double> ParseOctomapBinary(const std::string& bytes,
                                          const std::function<void(const VoxelCube&)>& visit);

}  // namespace isthmus::formats
