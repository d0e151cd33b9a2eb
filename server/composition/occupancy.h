// The merged map as an OctoMap: rays from where each keyframe's sensor stood, so that what was
// looked through is free and what was never seen stays unknown.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/composed_map.h"

namespace isthmus::composition {

struct OccupancyOptions {
  double resolution_m = 0.2;  // Edge of the smallest voxels, 0.01 to 10.
  // Rays are cut here: the way there is free, what lies beyond is not inserted as occupied. At
  // least the resolution, at most 1000.
  double max_range_m = 30;
  // Voxels whose middle is not in its box and sphere are left out, and cost no memory.
  Region region = {};
  uint64_t max_bytes = uint64_t{1} << 30;  // What grid and tree may take while being built, about.
};

enum class OccupancyFormat {
  kBinary,  // .bt: free, occupied or unknown.
  kFull,    // .ot: log-odds.
};

// The file's bytes: those of OctoMap's own writer, with its default sensor model (hit 0.7, miss
// 0.4, clamped to 0.12 and 0.97), one hit or miss per voxel and keyframe. A component without
// submaps gives the file of an empty tree. Takes on the order of a second for a building at 0.2 m.
//
// InvalidArgument for options out of range. OutOfRange when the map reaches farther than the
// 2^15 voxels from the origin that the format can tell apart. ResourceExhausted when more
// than max_bytes would be needed. Thread safe (no shared state).
//
// Submaps are read one after another, in the order given, and let go again. One that the reader has
// not is left out, and counted in `missing` unless that is null.
absl::StatusOr<std::string> WriteOccupancy(const std::vector<PlacedSubmap>& submaps,
                                           const SubmapReader& reader, uint32_t component,
                                           OccupancyFormat format, const OccupancyOptions& options,
                                           uint64_t* missing = nullptr);

}  // namespace isthmus::composition
