#include "server/matching/asking/seen_ground.h"

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/asking/limits.h"

namespace isthmus::matching {
namespace {

using Cells = absl::flat_hash_set<uint64_t>;

uint64_t KeyOf(double x, double y, int storey) {
  const auto column = static_cast<int32_t>(std::floor(x / kAskedCellM));
  const auto row = static_cast<int32_t>(std::floor(y / kAskedCellM));
  return (static_cast<uint64_t>(static_cast<uint16_t>(storey)) << 48) ^
         (static_cast<uint64_t>(static_cast<uint32_t>(column)) << 24) ^ static_cast<uint32_t>(row);
}

// The horizontal distance up to which the view from the stop shows ground or a wall.
double SeenUpTo(const Stop& stop, double yaw) {
  double farthest = 0;
  for (const double elevation : {0.0, -0.05, -0.1, -0.2, -0.35}) {
    const Eigen::Vector3d level(std::cos(yaw), std::sin(yaw), std::tan(elevation));
    const Eigen::Vector3d direction = stop.T_level_sensor.rotation().inverse() * level;
    RangeImage::Interval measured;
    if (!stop.view->At(direction.cast<float>(), &measured)) continue;
    farthest = std::max(farthest, std::cos(elevation) * double{measured.shortest});
  }
  return std::min(farthest, kAskedReachM);
}

Cells GroundFrom(const Stop& stop, double floor_z) {
  const Eigen::Vector3d& at = stop.T_level_sensor.translation();
  const auto storey = static_cast<int>(std::floor((at.z() - floor_z) / kStoreyM + 0.5));
  Cells cells;
  for (double yaw = 0; yaw < 2 * M_PI; yaw += kAskedStepRad) {
    const double reach = SeenUpTo(stop, yaw);
    for (double r = 0; r <= reach; r += kAskedCellM) {
      cells.insert(KeyOf(at.x() + r * std::cos(yaw), at.y() + r * std::sin(yaw), storey));
    }
  }
  return cells;
}

}  // namespace

std::vector<double> NewGround(const std::vector<Stop>& stops, const ShortestWays& ways,
                              bool driver_is_b) {
  std::vector<double> ground(stops.size(), 0);
  if (stops.empty()) return ground;
  const double floor_z = stops.front().T_level_sensor.translation().z();
  Cells seen;
  std::vector<std::vector<size_t>> after(stops.size());
  std::vector<Cells> news(stops.size());
  for (size_t i = 0; i < stops.size(); ++i) {
    if (ways.before[i]) after[*ways.before[i]].push_back(i);
    Cells cells = GroundFrom(stops[i], floor_z);
    if (stops[i].of_b == driver_is_b) {
      seen.merge(cells);
    } else {
      news[i] = std::move(cells);
    }
  }
  for (Cells& cells : news) {
    absl::erase_if(cells, [&](uint64_t key) { return seen.contains(key); });
  }
  // Down the tree of ways, and up again.
  absl::flat_hash_map<uint64_t, int> on_way;
  std::vector<std::pair<size_t, bool>> open;
  for (size_t i = 0; i < stops.size(); ++i) {
    if (ways.length_m[i] == 0) open.emplace_back(i, true);
  }
  while (!open.empty()) {
    const auto [at, enters] = open.back();
    if (enters) {
      open.back().second = false;
      for (const uint64_t key : news[at]) ++on_way[key];
      ground[at] = static_cast<double>(on_way.size()) * kAskedCellM * kAskedCellM;
      for (const size_t next : after[at]) open.emplace_back(next, true);
      continue;
    }
    open.pop_back();
    for (const uint64_t key : news[at]) {
      const auto found = on_way.find(key);
      if (--found->second == 0) on_way.erase(found);
    }
  }
  return ground;
}

}  // namespace isthmus::matching
