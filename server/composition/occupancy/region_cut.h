// A region as it cuts columns of evidence.
#pragma once

#include <memory>

#include "core/map/composed_map.h"
#include "server/composition/occupancy/column_key.h"
#include "server/composition/occupancy/packed_column.h"

namespace isthmus::composition {

// Box, sphere and shape of a region, asked by the middles of voxels. Value type; the region must
// outlive it.
class RegionCut {
 public:
  RegionCut(const Region& region, double resolution_m);

  // False only if no voxel of the column is inside.
  bool MayTouch(const ColumnKey& key) const;
  // The column itself where all of it is inside, else another with what is.
  std::shared_ptr<const PackedColumn> Cut(const ColumnKey& key,
                                          std::shared_ptr<const PackedColumn> column) const;

 private:
  bool Contains(const Eigen::Vector3d& middle) const;
  bool MayTouch(const Box& middles) const;
  bool ContainsAll(const Box& middles) const;
  // Of the middles of a cube's voxels.
  Box BoxOf(const ColumnKey& key, int32_t z) const;

  const Region& region_;
  const double resolution_m_;
  const bool is_everywhere_;
};

}  // namespace isthmus::composition
