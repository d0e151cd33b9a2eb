#include "core/floors/ground.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "core/floors/limits.h"

namespace isthmus::floors {
double SensorHeight(const std::vector<VoxelCube>& leaves, double resolution_m,
                    const std::vector<Eigen::Vector3d>& stations) {
  struct Column {
    double station_m = 0;
    double ground_m = -std::numeric_limits<double>::infinity();
  };
  absl::flat_hash_map<std::pair<int32_t, int32_t>, Column> columns;
  const auto index = [&](double at) { return static_cast<int32_t>(std::floor(at / resolution_m)); };
  for (const Eigen::Vector3d& station : stations) {
    columns.try_emplace({index(station.x()), index(station.y())}, Column{station.z()});
  }
  for (const VoxelCube& leaf : leaves) {
    if (!leaf.is_occupied) continue;
    const double top = (leaf.z + leaf.edge) * resolution_m;
    for (int32_t x = leaf.x; x < leaf.x + leaf.edge; ++x) {
      for (int32_t y = leaf.y; y < leaf.y + leaf.edge; ++y) {
        const auto column = columns.find({x, y});
        if (column == columns.end()) continue;
        Column& found = column->second;
        // A voxel of play: the sensor's own voxel is not its ground.
        if (top > found.station_m - resolution_m) continue;
        if (found.station_m - top <= kDeepestGroundM)
          found.ground_m = std::max(found.ground_m, top);
      }
    }
  }
  std::vector<double> heights;
  for (const auto& item : columns) {
    const Column& column = item.second;
    if (std::isfinite(column.ground_m)) heights.push_back(column.station_m - column.ground_m);
  }
  if (heights.empty()) return kUnknownSensorHeightM;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

HeightField::HeightField(const Eigen::Vector2d& origin, double resolution_m, int64_t width,
                         int64_t height, const std::vector<Eigen::Vector3d>& stations)
    : step_(std::max<int64_t>(1, std::llround(kHeightCellM / resolution_m))),
      columns_(width / step_ + 1),
      rows_(height / step_ + 1),
      heights_(static_cast<size_t>(columns_ * rows_), std::numeric_limits<double>::quiet_NaN()) {
  // In rings from the stations outwards: what reaches a cell first is nearest to it.
  std::deque<std::pair<int64_t, int64_t>> edge;
  const auto visit = [&](int64_t x, int64_t y, double station_m) {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return;
    double& known = heights_[static_cast<size_t>(y * columns_ + x)];
    if (!std::isnan(known)) return;
    known = station_m;
    edge.emplace_back(x, y);
  };
  const double cell_m = static_cast<double>(step_) * resolution_m;
  for (const Eigen::Vector3d& station : stations) {
    const Eigen::Vector2d at = (station.head<2>() - origin) / cell_m;
    // One outside counts at the border.
    visit(std::clamp<int64_t>(std::llround(std::floor(at.x())), 0, columns_ - 1),
          std::clamp<int64_t>(std::llround(std::floor(at.y())), 0, rows_ - 1), station.z());
  }
  for (; !edge.empty(); edge.pop_front()) {
    const auto [x, y] = edge.front();
    const double station_m = heights_[static_cast<size_t>(y * columns_ + x)];
    visit(x + 1, y, station_m);
    visit(x - 1, y, station_m);
    visit(x, y + 1, station_m);
    visit(x, y - 1, station_m);
  }
}

}  // namespace isthmus::floors
