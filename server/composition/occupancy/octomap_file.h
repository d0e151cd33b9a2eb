// OctoMap's files, written from columns of evidence without building an octree.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/map/free_space.h"
#include "server/composition/occupancy/column_key.h"
#include "server/composition/occupancy/packed_column.h"

namespace isthmus::composition {

enum class OccupancyFormat {
  kBinary,  // .bt: free, occupied or unknown.
  kFull,    // .ot: log-odds.
};

struct PlacedColumn {
  ColumnKey key;  // Within 2^9 columns of the origin.
  std::shared_ptr<const PackedColumn> column;
};

// The bytes that OctoMap 1.9 writes of the same leaves: pruned; for .bt to the maximum likelihood
// first. Each column at most once, in any order. Cubes must lie within 2^9 of the origin.
// ResourceExhausted where there are more than `max_bytes`.
absl::StatusOr<std::string> FormatOctomap(const std::vector<PlacedColumn>& columns,
                                          OccupancyFormat format, double resolution_m,
                                          uint64_t max_bytes);
// The leaves of that .bt file, in another order; ResourceExhausted where its tree has more bytes.
absl::StatusOr<std::vector<VoxelCube>> OctomapCubes(const std::vector<PlacedColumn>& columns,
                                                    uint64_t max_bytes);

}  // namespace isthmus::composition
