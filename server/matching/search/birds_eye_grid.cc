#include "server/matching/search/birds_eye_grid.h"

#include <algorithm>

#include "server/matching/search/limits.h"

namespace isthmus::matching {

// Around where the robot was, as far as it is looked from there.
Eigen::AlignedBox2f ExtentOf(const WallMap& map, const SceneScale& scale) {
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& sensor : map.sensors()) box.extend(sensor.head<2>());
  if (box.isEmpty()) return box;
  const Eigen::Vector2f range = Eigen::Vector2f::Constant(scale.max_range_m);
  return {box.min() - range, box.max() + range};
}

BirdsEyeGrid MakeBirdsEyeGrid(const WallMap& map, const SceneScale& scale, double cell_m) {
  BirdsEyeGrid grid;
  const Eigen::AlignedBox2f extent = ExtentOf(map, scale);
  if (extent.isEmpty()) return grid;
  grid.origin = extent.min();
  grid.cell = static_cast<float>(cell_m);
  grid.inverse_cell = 1 / grid.cell;
  const Eigen::Vector2f size = extent.sizes() * grid.inverse_cell;
  // In cells half as large as those whose shifts are that many.
  if (!((size.x() + 1) * (size.y() + 1) < 2.1 * kMaxPlanCells)) return grid;
  grid.width = static_cast<int>(size.x()) + 1;
  grid.rows = static_cast<int>(size.y()) + 1;
  return grid;
}

std::vector<BirdsEyeColumn> CollectWalls(const WallMap& map, const SceneScale& scale,
                                         const BirdsEyeGrid& grid) {
  std::vector<BirdsEyeColumn> columns(static_cast<size_t>(grid.width) * grid.rows);
  const float to_layer = kWallLayers / (scale.wall.high - scale.wall.low);
  for (const WallPoint& wall : map.walls()) {
    if (wall.height < scale.wall.low || wall.height >= scale.wall.high) continue;
    const int i = grid.Index(wall.position.head<2>());
    if (i < 0) continue;
    BirdsEyeColumn& column = columns[i];
    column.normal += wall.normal;
    column.layers |= 1u << std::min(kWallLayers - 1,
                                    static_cast<int>((wall.height - scale.wall.low) * to_layer));
    ++column.count;
  }
  return columns;
}

std::vector<uint8_t> CollectFree(const WallMap& map, const SceneScale& scale,
                                 const BirdsEyeGrid& grid) {
  std::vector<uint8_t> hits(static_cast<size_t>(grid.width) * grid.rows, 0);
  for (const FreeRay& ray : map.FreeRays(scale)) {
    const Eigen::Vector2f along = ray.to - ray.from;
    const float length = along.norm();
    // The last cell belongs to what stopped the ray.
    const int steps = static_cast<int>(length * grid.inverse_cell) - 1;
    const Eigen::Vector2f step = along / std::max(length * grid.inverse_cell, 1e-3f);
    Eigen::Vector2f p = ray.from;
    for (int i = 0; i < steps; ++i, p += step) {
      const int cell = grid.Index(p);
      if (cell >= 0 && hits[cell] < 255) ++hits[cell];
    }
  }
  return hits;
}

}  // namespace isthmus::matching
