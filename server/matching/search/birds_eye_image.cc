#include "server/matching/search/birds_eye_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "server/matching/search/birds_eye_grid.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

bool NearWall(const std::vector<BirdsEyeColumn>& columns, const BirdsEyeGrid& grid, int x, int y) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (grid.Inside(x + dx, y + dy) && columns[(y + dy) * grid.width + x + dx].count > 0) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

void BirdsEyeCells::Enclose() {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector2f high = -low;
  const auto extend = [&](const Eigen::Vector2f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const auto& wall : walls) extend(wall.position);
  for (const auto& p : free) extend(p);
  if (low.x() > high.x()) return;
  center = 0.5f * (low + high);
  for (const auto& wall : walls) {
    radius = std::max(radius, (wall.position - center).norm());
  }
  for (const auto& p : free) {
    radius = std::max(radius, (p - center).norm());
  }
  radius += static_cast<float>(cell_m);
}

double CellThatFits(const WallMap& a, const WallMap& b, const SceneScale& scale, double cell_m) {
  // However it is turned, a map fits into the square around the circle around it.
  double side_m = 0;
  for (const WallMap* map : {&a, &b}) {
    const Eigen::AlignedBox2f extent = ExtentOf(*map, scale);
    if (!extent.isEmpty()) side_m += extent.diagonal().cast<double>().norm();
  }
  while (std::isfinite(side_m) && std::pow(side_m / cell_m, 2) > kMaxPlanCells) cell_m *= 2;
  return cell_m;
}

BirdsEyeCells MakeBirdsEyeCells(const WallMap& map, const SceneScale& scale, double cell_m) {
  BirdsEyeCells cells;
  cells.cell_m = cell_m;
  const BirdsEyeGrid grid = MakeBirdsEyeGrid(map, scale, cell_m);
  if (grid.width == 0) return cells;
  const std::vector<BirdsEyeColumn> columns = CollectWalls(map, scale, grid);
  const std::vector<uint8_t> hits = CollectFree(map, scale, grid);
  for (int i = 0; i < grid.width * grid.rows; ++i) {
    const BirdsEyeColumn& column = columns[i];
    if (column.count > 0 || hits[i] > 0) cells.known.push_back(grid.Center(i));
    if (column.count > 0) {
      const float filled = static_cast<float>(std::popcount(column.layers));
      const float weight = std::min(1.0f, filled / (0.5f * kWallLayers));
      cells.walls.push_back(
          {grid.Center(i), weight / static_cast<float>(column.count) * column.normal, weight});
    } else if (hits[i] >= 2 && !NearWall(columns, grid, i % grid.width, i / grid.width)) {
      cells.free.push_back(grid.Center(i));
    }
  }
  cells.Enclose();
  return cells;
}

void Blur(int width, int rows, std::vector<float>* plane) {
  std::vector<float> row(static_cast<size_t>(width));
  for (int y = 0; y < rows; ++y) {
    float* p = plane->data() + static_cast<size_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      row[x] = p[x] + 0.5f * ((x > 0 ? p[x - 1] : 0) + (x + 1 < width ? p[x + 1] : 0));
    }
    std::copy(row.begin(), row.end(), p);
  }
  const std::vector<float> source = *plane;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t i = static_cast<size_t>(y) * width + x;
      (*plane)[i] = source[i] + 0.5f * ((y > 0 ? source[i - width] : 0) +
                                        (y + 1 < rows ? source[i + width] : 0));
    }
  }
}

BirdsEyeImage MakeReferenceImage(const BirdsEyeCells& cells, double free_space_weight) {
  BirdsEyeImage image;
  image.cell_m = static_cast<float>(cells.cell_m);
  image.origin = cells.center.array() - cells.radius - 2 * image.cell_m;
  image.width = image.rows = static_cast<int>(2 * cells.radius / image.cell_m) + 5;
  const size_t size = static_cast<size_t>(image.width) * image.rows;
  for (auto& plane : image.planes) plane.assign(size, 0.0f);
  const auto index = [&](const Eigen::Vector2f& p) {
    const int x = CellAt((p.x() - image.origin.x()) / image.cell_m, image.width);
    const int y = CellAt((p.y() - image.origin.y()) / image.cell_m, image.rows);
    return static_cast<size_t>(y) * image.width + x;
  };
  for (const auto& wall : cells.walls) {
    const size_t i = index(wall.position);
    image.planes[BirdsEyeImage::kNormalX][i] = wall.normal.x();
    image.planes[BirdsEyeImage::kNormalY][i] = wall.normal.y();
    image.planes[BirdsEyeImage::kWall][i] = wall.weight;
  }
  std::vector<float> sharp_walls = image.planes[BirdsEyeImage::kWall];
  for (int k = 0; k < BirdsEyeImage::kFree; ++k) Blur(image.width, image.rows, &image.planes[k]);
  const float weight = static_cast<float>(free_space_weight);
  for (size_t i = 0; i < size; ++i) {
    // A long wall's cells add up in the blur: cut back to the worth of one.
    Eigen::Vector2f normal(image.planes[0][i], image.planes[1][i]);
    const float length = normal.norm();
    if (length > 1) normal /= length;
    image.planes[BirdsEyeImage::kNormalX][i] = normal.x();
    image.planes[BirdsEyeImage::kNormalY][i] = normal.y();
    float& wall = image.planes[BirdsEyeImage::kWall][i];
    wall = kUnorientedShare * std::min(wall, 1.0f);
    image.planes[BirdsEyeImage::kFree][i] = -weight * sharp_walls[i];
  }
  // A free cell is no wall's and no neighbour of one's: the blurred agreement and the conflict of
  // the moved map's walls share a plane.
  for (const auto& p : cells.free) image.planes[BirdsEyeImage::kWall][index(p)] -= weight;
  return image;
}

}  // namespace isthmus::matching
