// The remembered map seen from above, as a correlative scan matcher needs it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "floam/map/map_memory.h"

namespace isthmus::floam {

// A window of the map: square cells of MapMemory::kCellM, row by row. The sensor may be in the
// cells [margin, width - margin) of both axes; the margin is what it sees from there.
struct WallImage {
  static constexpr int8_t kWall = 100, kNearWall = kWall / 2, kUnknown = 0, kFlat = -kWall / 2;

  int width = 0;  // Cells of either axis.
  int margin = 0;
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // Low corner of the window, odom.
  std::vector<int8_t> values;      // Worth of a wall of the scan that falls into the cell.
  std::vector<uint8_t> standable;  // 1 where the sensor may be.

  Eigen::Vector2d CentreOf(int x, int y) const {
    return corner + MapMemory::kCellM * Eigen::Vector2d(x + 0.5, y + 0.5);
  }
};

// The window whose inner part is the square of `side_m` at `low` (moved to whole tiles). The sensor
// may be where a remembered position of it is within `reach_m`.
WallImage MakeWallImage(const MapMemory& memory, const std::vector<Eigen::Vector3d>& sensors,
                        const Eigen::Vector2d& low, double side_m, double margin_m, double reach_m);

}  // namespace isthmus::floam
