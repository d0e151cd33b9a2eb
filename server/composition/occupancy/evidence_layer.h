// The columns of evidence of one map at one resolution, and what each of them is made of.
#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/ids.h"
#include "server/composition/occupancy/column_key.h"
#include "server/composition/occupancy/packed_column.h"

namespace isthmus::composition {

// Copies share columns.
struct EvidenceLayer {
  struct Column {
    // Hash of the submaps that reach it, their poses and their order.
    uint64_t made_of = 0;
    std::shared_ptr<const PackedColumn> packed;
  };
  struct CastSubmap {
    uint64_t stamp = 0;                                     // Hash of its content and pose.
    std::shared_ptr<const std::vector<ColumnKey>> columns;  // Columns its rays reach, in order.
  };

  double resolution_m = 0, max_range_m = 0;
  RobotId robot;  // Its rays alone; empty: all robots'.
  std::map<SubmapId, CastSubmap> submaps;
  // Columns that were not asked for, or that memory had no room for, are missing.
  absl::flat_hash_map<ColumnKey, Column> columns;

  uint64_t bytes() const;  // In memory, about.
};

}  // namespace isthmus::composition
