// The grid of a plan view: the walls in its cells, and the rays across them.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

// Cells of a map's level frame, row by row.
struct BirdsEyeGrid {
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();  // Corner of cell (0, 0).
  float inverse_cell = 1, cell = 1;
  int width = 0, rows = 0;

  bool Inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < rows; }
  int Column(float x) const {
    return static_cast<int>(std::floor((x - origin.x()) * inverse_cell));
  }
  int Row(float y) const { return static_cast<int>(std::floor((y - origin.y()) * inverse_cell)); }
  // Index of the cell that a place lies in; -1 outside.
  int Index(const Eigen::Vector2f& at) const {
    const int x = Column(at.x()), y = Row(at.y());
    return Inside(x, y) ? y * width + x : -1;
  }
  size_t size() const { return static_cast<size_t>(width) * static_cast<size_t>(rows); }
  Eigen::Vector2f Center(int i) const {
    const int x = i % width, y = i / width;
    return origin +
           cell * Eigen::Vector2f(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  }
};

// The walls over a cell.
struct BirdsEyeColumn {
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();  // Sum over its walls.
  int count = 0;                                     // Number of its walls.
  uint32_t layers = 0;                               // Heights that are filled.
};

// Around where the robot was, as far as it is looked from there.
Eigen::AlignedBox2f ExtentOf(const WallMap& map, const SceneScale& scale);

// Without cells where there would be too many, see CellThatFits.
BirdsEyeGrid MakeBirdsEyeGrid(const WallMap& map, const SceneScale& scale, double cell_m);

// The walls within the scale's band, in kWallLayers layers.
std::vector<BirdsEyeColumn> CollectWalls(const WallMap& map, const SceneScale& scale,
                                         const BirdsEyeGrid& grid);
// Number of rays through each cell, up to 255.
std::vector<uint8_t> CollectFree(const WallMap& map, const SceneScale& scale,
                                 const BirdsEyeGrid& grid);

}  // namespace isthmus::matching
