// A region as it cuts columns of evidence.
#pragma once

#include <memory>

#include "core/map/region_extent.h"
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
  // The box of the middles of a cube's voxels.
  Box BoxOf(const ColumnKey& key, int32_t z) const;

  const RegionExtent extent_;
  const double resolution_m_;
};

}  // namespace isthmus::composition
