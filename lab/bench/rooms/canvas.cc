#include "lab/bench/rooms/canvas.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace isthmus::bench {
namespace {

constexpr double kCellM = 0.05, kMarginM = 0.5;
constexpr double kLowM = 0.1, kHighM = 1;  // Above the floor.

}  // namespace

Canvas::Canvas(const simulation::wild::Plan& plan, double yaw) : T_map_plan_(yaw) {
  Eigen::Vector2d low(0, 0), high(0, 0);
  for (const auto& room : plan.rooms) {
    for (const double x : {room.min.x(), room.max.x()}) {
      for (const double y : {room.min.y(), room.max.y()}) {
        const Eigen::Vector2d at = InMap({x, y});
        low = low.cwiseMin(at), high = high.cwiseMax(at);
      }
    }
  }
  map_.resolution_m = kCellM;
  map_.origin = low.array() - kMarginM;
  map_.width = std::lround(((high - low).x() + 2 * kMarginM) / kCellM);
  map_.height = std::lround(((high - low).y() + 2 * kMarginM) / kCellM);
  map_.cells.assign(static_cast<size_t>(map_.width * map_.height), floors::GridCell::kUnknown);
}

size_t Canvas::CellAt(const Eigen::Vector2d& in_plan) const {
  const Eigen::Vector2d at = (InMap(in_plan) - map_.origin) / kCellM;
  const auto x = std::clamp<int64_t>(static_cast<int64_t>(at.x()), 0, map_.width - 1);
  const auto y = std::clamp<int64_t>(static_cast<int64_t>(at.y()), 0, map_.height - 1);
  return static_cast<size_t>(y * map_.width + x);
}

Eigen::Vector2d Canvas::InPlan(int64_t x, int64_t y) const {
  const Eigen::Vector2d at(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
  return T_map_plan_.inverse() * (map_.origin + kCellM * at);
}

void Canvas::Occupy(const std::array<Eigen::Vector3d, 3>& corners, floors::GridMap* map) const {
  constexpr double kStepM = 0.6 * kCellM;  // Points on the triangle lie closer than cells.
  const Eigen::Vector3d u = corners[1] - corners[0], v = corners[2] - corners[0];
  const double low = std::min({corners[0].z(), corners[1].z(), corners[2].z()});
  const double high = std::max({corners[0].z(), corners[1].z(), corners[2].z()});
  if (low > kHighM || high < kLowM) return;
  const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
  const int steps = std::max(1, static_cast<int>(std::ceil(longest / kStepM)));
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; i + k <= steps; ++k) {
      const Eigen::Vector3d at = corners[0] + (u * i + v * k) / steps;
      if (at.z() < kLowM || at.z() > kHighM) continue;
      map->cells[CellAt(at.head<2>())] = floors::GridCell::kOccupied;
    }
  }
}

void FreeFrom(size_t first, floors::GridMap* map) {
  std::vector<size_t> ways{first};
  while (!ways.empty()) {
    const size_t cell = ways.back();
    ways.pop_back();
    if (map->cells[cell] != floors::GridCell::kUnknown) continue;
    map->cells[cell] = floors::GridCell::kFree;
    const auto x = static_cast<int64_t>(cell) % map->width;
    const auto y = static_cast<int64_t>(cell) / map->width;
    if (x > 0) ways.push_back(cell - 1);
    if (y > 0) ways.push_back(cell - static_cast<size_t>(map->width));
    if (x + 1 < map->width) ways.push_back(cell + 1);
    if (y + 1 < map->height) ways.push_back(cell + static_cast<size_t>(map->width));
  }
}

}  // namespace isthmus::bench
