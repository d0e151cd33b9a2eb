#include "server/composition/occupancy/region_cut.h"

#include <limits>

namespace isthmus::composition {

RegionCut::RegionCut(const Region& region, double resolution_m)
    : extent_(region), resolution_m_(resolution_m) {}

Box RegionCut::BoxOf(const ColumnKey& key, int32_t z) const {
  const Eigen::Vector3d lowest =
      (VoxelIndex(key.x, key.y, z) * kColumnEdge).cast<double>().array() + 0.5;
  Box box;
  box.min = lowest * resolution_m_;
  box.max = (lowest.array() + (kColumnEdge - 1)) * resolution_m_;
  return box;
}

bool RegionCut::MayTouch(const ColumnKey& key) const {
  if (extent_.is_everywhere()) return true;
  Box box = BoxOf(key, 0);
  constexpr double kFar = std::numeric_limits<double>::max();
  box.min.z() = -kFar;
  box.max.z() = kFar;
  return extent_.MayTouch(box);
}

std::shared_ptr<const PackedColumn> RegionCut::Cut(
    const ColumnKey& key, std::shared_ptr<const PackedColumn> column) const {
  if (extent_.is_everywhere()) return column;
  bool is_whole = true;
  VoxelColumn inside;
  for (const PackedColumn::Cube& cube : column->cubes()) {
    const Box middles = BoxOf(key, cube.z);
    if (extent_.ContainsAll(middles)) {
      column->Unpack(cube, 1, &inside);
      continue;
    }
    is_whole = false;
    if (!extent_.MayTouch(middles)) continue;
    VoxelColumn whole;
    column->Unpack(cube, 1, &whole);
    const VoxelIndex lowest = VoxelIndex(0, 0, cube.z) * kColumnEdge;
    for (int i = 0; i < kColumnEdge * kColumnEdge * kColumnEdge; ++i) {
      const VoxelIndex at =
          VoxelIndex(i % kColumnEdge, i / kColumnEdge % kColumnEdge, i / kColumnEdge / kColumnEdge);
      const VoxelCell* cell = whole.Find(lowest + at);
      if (cell == nullptr || cell->scan == 0) continue;
      if (extent_.Contains(middles.min + at.cast<double>() * resolution_m_))
        inside.At(lowest + at) = *cell;
    }
  }
  return is_whole ? column : std::make_shared<const PackedColumn>(inside);
}

}  // namespace isthmus::composition
