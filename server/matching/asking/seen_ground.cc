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

uint64_t KeyOf(double x, double y) {
  const auto column = static_cast<int32_t>(std::floor(x / kAskedCellM));
  const auto row = static_cast<int32_t>(std::floor(y / kAskedCellM));
  return static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
}

// The horizontal distance up to which the view from the stop shows ground or a wall.
double SeenUpTo(const Stop& stop, double yaw, double reach_m) {
  double farthest = 0;
  for (const double elevation : {0.0, -0.05, -0.1, -0.2, -0.35}) {
    const Eigen::Vector3d level(std::cos(yaw), std::sin(yaw), std::tan(elevation));
    const Eigen::Vector3d direction = stop.T_level_sensor.rotation().inverse() * level;
    RangeImage::Interval measured;
    if (!stop.view->At(direction.cast<float>(), &measured)) continue;
    farthest = std::max(farthest, std::cos(elevation) * double{measured.shortest});
  }
  return std::min(farthest, reach_m);
}

Cells GroundFrom(const Stop& stop, double reach_m) {
  const Eigen::Vector3d& at = stop.T_level_sensor.translation();
  Cells cells;
  for (double yaw = 0; yaw < 2 * M_PI; yaw += kAskedStepRad) {
    const double reach = SeenUpTo(stop, yaw, reach_m);
    for (double r = 0; r <= reach; r += kAskedCellM) {
      cells.insert(KeyOf(at.x() + r * std::cos(yaw), at.y() + r * std::sin(yaw)));
    }
  }
  return cells;
}

double Area(size_t cells) { return static_cast<double>(cells) * kAskedCellM * kAskedCellM; }

// The area of all cells of the stops on the way to each: down the tree of ways, and up again.
void AddAlongWays(const ShortestWays& ways, const std::vector<Cells>& cells,
                  std::vector<double>* area_m2) {
  std::vector<std::vector<size_t>> after(cells.size());
  std::vector<std::pair<size_t, bool>> open;  // Stops, and whether they are still to be entered.
  for (size_t i = 0; i < cells.size(); ++i) {
    if (ways.before[i]) after[*ways.before[i]].push_back(i);
    if (ways.length_m[i] == 0) open.emplace_back(i, true);
  }
  absl::flat_hash_map<uint64_t, int> on_way;
  while (!open.empty()) {
    const auto [at, enters] = open.back();
    if (enters) {
      open.back().second = false;
      for (const uint64_t key : cells[at]) ++on_way[key];
      (*area_m2)[at] = Area(on_way.size());
      for (const size_t next : after[at]) open.emplace_back(next, true);
      continue;
    }
    open.pop_back();
    for (const uint64_t key : cells[at]) {
      const auto found = on_way.find(key);
      if (--found->second == 0) on_way.erase(found);
    }
  }
}

}  // namespace

SharedGround MeasureSharedGround(const std::vector<Stop>& stops, const ShortestWays& ways,
                                 bool driver_is_b, bool outdoors) {
  SharedGround ground;
  ground.new_m2.resize(stops.size(), 0);
  const double reach_m = outdoors ? kSeenWellOutdoorsM : kSeenWellM;
  Cells of_driver, of_both;
  std::vector<Cells> news(stops.size());
  for (size_t i = 0; i < stops.size(); ++i) {
    news[i] = GroundFrom(stops[i], reach_m);
    if (stops[i].of_b == driver_is_b) of_driver.merge(news[i]);
  }
  for (size_t i = 0; i < stops.size(); ++i) {
    if (stops[i].of_b == driver_is_b) news[i].clear();
    absl::erase_if(news[i], [&](uint64_t key) {
      return of_driver.contains(key) && (of_both.insert(key), true);
    });
  }
  ground.now_m2 = Area(of_both.size());
  AddAlongWays(ways, news, &ground.new_m2);
  return ground;
}

}  // namespace isthmus::matching
