#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/path.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kIndexCell = 4;  // Metres.

int64_t Key(int64_t x, int64_t y) { return (x << 32) ^ (y & 0xFFFFFFFF); }
int64_t CellOf(double x) { return static_cast<int64_t>(std::floor(x / kIndexCell)); }

}  // namespace

PathIndex::PathIndex(const Path& path)
    : min_(path.points()[0].head<2>()), max_(path.points()[0].head<2>()) {
  constexpr double kEvery = 0.5;
  for (double s = 0; s <= path.length(); s += kEvery) {
    const Eigen::Vector2d at = path.At(s).position.head<2>();
    min_ = min_.cwiseMin(at);
    max_ = max_.cwiseMax(at);
    cells_[Key(CellOf(at.x()), CellOf(at.y()))].push_back({at, s});
  }
}

Eigen::Vector2d PathIndex::Anywhere(double reach_m, Random& random) const {
  const double x = random.Uniform(min_.x() - reach_m, max_.x() + reach_m);
  return {x, random.Uniform(min_.y() - reach_m, max_.y() + reach_m)};
}

PathIndex::Near PathIndex::Nearest(const Eigen::Vector2d& at, double reach_m) const {
  Near near{reach_m, 0};
  // From the middle outwards, to be done as soon as nothing nearer can come.
  const int64_t x = CellOf(at.x()), y = CellOf(at.y());
  const auto rings = static_cast<int64_t>(std::ceil(reach_m / kIndexCell));
  for (int64_t ring = 0; ring <= rings; ++ring) {
    if (static_cast<double>(ring - 1) * kIndexCell > near.distance_m) break;
    for (int64_t dx = -ring; dx <= ring; ++dx) {
      const int64_t step = std::abs(dx) == ring ? 1 : std::max<int64_t>(2 * ring, 1);
      for (int64_t dy = -ring; dy <= ring; dy += step) {
        const auto cell = cells_.find(Key(x + dx, y + dy));
        if (cell == cells_.end()) continue;
        for (const Entry& entry : cell->second) {
          const double distance = (entry.at - at).norm();
          if (distance < near.distance_m) near = {distance, entry.s};
        }
      }
    }
  }
  return near;
}

}  // namespace isthmus::simulation::wild
