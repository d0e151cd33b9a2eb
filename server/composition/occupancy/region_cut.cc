#include "server/composition/occupancy/region_cut.h"

#include <limits>

namespace isthmus::composition {

RegionCut::RegionCut(const Region& region, double resolution_m)
    : region_(region),
      resolution_m_(resolution_m),
      is_everywhere_(region.box.empty() && !region.has_sphere && region.shape == nullptr) {}

bool RegionCut::Contains(const Eigen::Vector3d& middle) const {
  if (!region_.box.empty() && !region_.box.Contains(middle)) return false;
  if (region_.shape != nullptr && !region_.shape->Contains(middle)) return false;
  return !region_.has_sphere || (middle - region_.center).norm() <= region_.radius_m;
}

bool RegionCut::MayTouch(const Box& middles) const {
  if (!region_.box.empty() && !region_.box.Intersects(middles)) return false;
  if (region_.shape != nullptr && !region_.shape->MayTouch(middles)) return false;
  const Eigen::Vector3d nearest = region_.center.cwiseMax(middles.min).cwiseMin(middles.max);
  return !region_.has_sphere || (nearest - region_.center).norm() <= region_.radius_m;
}

bool RegionCut::ContainsAll(const Box& middles) const {
  if (!region_.box.empty() &&
      !(region_.box.Contains(middles.min) && region_.box.Contains(middles.max))) {
    return false;
  }
  if (region_.shape != nullptr && !region_.shape->ContainsAll(middles)) return false;
  const Eigen::Vector3d farthest =
      (middles.min - region_.center).cwiseAbs().cwiseMax((middles.max - region_.center).cwiseAbs());
  return !region_.has_sphere || farthest.norm() <= region_.radius_m;
}

Box RegionCut::BoxOf(const ColumnKey& key, int32_t z) const {
  const Eigen::Vector3d lowest =
      (VoxelIndex(key.x, key.y, z) * kColumnEdge).cast<double>().array() + 0.5;
  Box box;
  box.min = lowest * resolution_m_;
  box.max = (lowest.array() + (kColumnEdge - 1)) * resolution_m_;
  return box;
}

bool RegionCut::MayTouch(const ColumnKey& key) const {
  if (is_everywhere_) return true;
  Box box = BoxOf(key, 0);
  constexpr double kFar = std::numeric_limits<double>::max();
  box.min.z() = -kFar;
  box.max.z() = kFar;
  return MayTouch(box);
}

std::shared_ptr<const PackedColumn> RegionCut::Cut(
    const ColumnKey& key, std::shared_ptr<const PackedColumn> column) const {
  if (is_everywhere_) return column;
  bool is_whole = true;
  VoxelColumn inside;
  for (const PackedColumn::Cube& cube : column->cubes()) {
    const Box middles = BoxOf(key, cube.z);
    if (ContainsAll(middles)) {
      column->Unpack(cube, 1, &inside);
      continue;
    }
    is_whole = false;
    if (!MayTouch(middles)) continue;
    VoxelColumn whole;
    column->Unpack(cube, 1, &whole);
    const VoxelIndex lowest = VoxelIndex(0, 0, cube.z) * kColumnEdge;
    for (int i = 0; i < kColumnEdge * kColumnEdge * kColumnEdge; ++i) {
      const VoxelIndex at =
          VoxelIndex(i % kColumnEdge, i / kColumnEdge % kColumnEdge, i / kColumnEdge / kColumnEdge);
      const VoxelCell* cell = whole.Find(lowest + at);
      if (cell == nullptr || cell->scan == 0) continue;
      if (Contains(middles.min + at.cast<double>() * resolution_m_)) inside.At(lowest + at) = *cell;
    }
  }
  return is_whole ? column : std::make_shared<const PackedColumn>(inside);
}

}  // namespace isthmus::composition
