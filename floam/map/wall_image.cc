#include "floam/map/wall_image.h"

#include <algorithm>
#include <cmath>

namespace isthmus::floam {
namespace {

void MarkStandable(const std::vector<Eigen::Vector3d>& sensors, double reach_m, WallImage* image) {
  const int reach = static_cast<int>(std::ceil(reach_m / MapMemory::kCellM));
  for (const Eigen::Vector3d& sensor : sensors) {
    const Eigen::Vector2d at = (sensor.head<2>() - image->corner) / MapMemory::kCellM;
    const int cx = static_cast<int>(std::floor(at.x())), cy = static_cast<int>(std::floor(at.y()));
    const int end = image->width - image->margin;
    for (int y = std::max(cy - reach, image->margin); y < std::min(cy + reach + 1, end); ++y) {
      for (int x = std::max(cx - reach, image->margin); x < std::min(cx + reach + 1, end); ++x) {
        const int dx = x - cx, dy = y - cy;
        if (dx * dx + dy * dy <= reach * reach) {
          image->standable[static_cast<size_t>(y) * image->width + x] = 1;
        }
      }
    }
  }
}

void CopyCells(const MapMemory& memory, WallImage* image) {
  const int tiles = image->width / MapMemory::kCells;
  const MapMemory::TileIndex first = MapMemory::TileAt(image->corner.x() + 0.5 * MapMemory::kCellM,
                                                       image->corner.y() + 0.5 * MapMemory::kCellM);
  for (int k = 0; k < tiles * tiles; ++k) {
    const int tx = k % tiles, ty = k / tiles;
    const auto* cells = memory.Cells({first.x + tx, first.y + ty});
    if (cells == nullptr) continue;
    for (size_t c = 0; c < cells->size(); ++c) {
      const size_t x = tx * MapMemory::kCells + c % MapMemory::kCells;
      const size_t y = ty * MapMemory::kCells + c / MapMemory::kCells;
      int8_t& value = image->values[y * image->width + x];
      if ((*cells)[c] == MapMemory::Cell::kWall) value = WallImage::kWall;
      if ((*cells)[c] == MapMemory::Cell::kFlat) value = WallImage::kFlat;
    }
  }
}

// Poses are tried cell by cell: a wall also counts, for less, in the cells around its own.
void Blur(WallImage* image) {
  const int width = image->width;
  std::vector<int8_t> blurred = image->values;
  for (int y = 1; y + 1 < width; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const size_t at = static_cast<size_t>(y) * width + x;
      if (image->values[at] != WallImage::kWall) continue;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          int8_t& value = blurred[at + static_cast<size_t>(dy * width + dx)];
          value = std::max(value, WallImage::kNearWall);
        }
      }
    }
  }
  image->values.swap(blurred);
}

}  // namespace

WallImage MakeWallImage(const MapMemory& memory, const std::vector<Eigen::Vector3d>& sensors,
                        const Eigen::Vector2d& low, double side_m, double margin_m,
                        double reach_m) {
  const auto tiles = [](double metres) {
    return static_cast<int>(std::ceil(metres / MapMemory::kTileM));
  };
  const MapMemory::TileIndex first = MapMemory::TileAt(low.x(), low.y());
  WallImage image;
  image.margin = tiles(margin_m) * MapMemory::kCells;
  image.width = tiles(side_m) * MapMemory::kCells + 2 * image.margin;
  image.corner =
      MapMemory::kTileM * Eigen::Vector2d(first.x - tiles(margin_m), first.y - tiles(margin_m));
  const size_t cells = static_cast<size_t>(image.width) * image.width;
  image.values.assign(cells, WallImage::kUnknown);
  image.standable.assign(cells, 0);
  CopyCells(memory, &image);
  Blur(&image);
  MarkStandable(sensors, reach_m, &image);
  return image;
}

}  // namespace isthmus::floam
