// The merged map as an OctoMap: rays from where each keyframe's sensor stood, so that what was
// looked through is free and what was never seen stays unknown.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <string>
#include <vector>

#include "core/composed_map.h"

namespace isthmus::composition {

struct OccupancyOptions {
  double resolution_m = 0.2;
  double max_range_m = 30;  // Rays are cut here; what lies beyond is not inserted as occupied.
};

enum class OccupancyFormat {
  kBinary,  // .bt: free, occupied or unknown.
  kFull,    // .ot: log-odds.
};

// The file's bytes. ResourceExhausted when the tree would need more than about 1 GB.
absl::StatusOr<std::string> WriteOccupancy(const std::vector<PlacedSubmap>& submaps,
                                           uint32_t component, OccupancyFormat format,
                                           const OccupancyOptions& options);

}  // namespace isthmus::composition
