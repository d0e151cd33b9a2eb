#include "server/classes/ground_grid.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include "server/classes/limits.h"

namespace isthmus::classes {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();  // Math

// The value below which so large a share lies. Changes the order.
float ShareOf(std::vector<float>* values, double share) {
  const auto at = values->begin() + static_cast<long>(share * static_cast<double>(values->size()));
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

}  // namespace

Layout Layout::Around(std::span<const Eigen::Vector3f> points) {
  if (points.empty()) return {{0, 0}, static_cast<float>(kTerrainCellM), 1, 1};
  Eigen::Vector2f min = points.front().head<2>(), max = min;
  for (const Eigen::Vector3f& p : points) {
    min = min.cwiseMin(p.head<2>());
    max = max.cwiseMax(p.head<2>());
  }
  const Eigen::Vector2d size = (max - min).cast<double>().array() + kTerrainCellM;
  const double edge = std::max({kTerrainCellM, std::sqrt(size.prod() / kMostTerrainCells),
                                size.maxCoeff() / kMostTerrainCells});
  const Eigen::Vector2d cells = (size / edge).array().ceil() + 1;
  return {min, static_cast<float>(edge), static_cast<int>(cells.x()), static_cast<int>(cells.y())};
}

Eigen::Vector2i Layout::Find(const Eigen::Vector3f& p) const {
  const Eigen::Vector2i cell = ((p.head<2>() - origin) / edge_m).array().floor().cast<int>();
  return cell.cwiseMax(0).cwiseMin(Eigen::Vector2i(width - 1, height - 1));
}

GroundGrid::GroundGrid(std::span<const Eigen::Vector3f> points,
                       std::span<const Eigen::Vector3f> sensors)
    : layout_(Layout::Around(points)), cells_(layout_.size(), Cell{.lowest_m = kNone}) {
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2i at = layout_.Find(p);
    float& lowest = cells_[layout_.At(at.x(), at.y())].lowest_m;
    lowest = std::min(lowest, p.z());
  }
  LookAround();
  Grow(sensors);
}

// Only what points will ask for.
void GroundGrid::LookAround() {
  for (int y = 0; y < layout_.height; ++y) {
    for (int x = 0; x < layout_.width; ++x) {
      Cell& cell = cells_[layout_.At(x, y)];
      const bool has_points = cell.lowest_m < kNone;
      cell.lowest_near_m = has_points ? LowestWithin(x, y, 1) : kNone;
      cell.lowest_around_m = has_points ? LowestWithin(x, y, 3) : kNone;
    }
  }
}

// The median over the sensors of the height above the ground around each.
float GroundGrid::SensorHeight(std::span<const Eigen::Vector3f> sensors) const {
  constexpr double kOfGround = 0.3;  // Some cells have only what stands on it.
  std::vector<float> heights, around;
  for (const Eigen::Vector3f& sensor : sensors) {
    around.clear();
    const Eigen::Vector2i at = layout_.Find(sensor);
    for (int y = at.y() - kSensorGroundCells; y <= at.y() + kSensorGroundCells; ++y) {
      for (int x = at.x() - kSensorGroundCells; x <= at.x() + kSensorGroundCells; ++x) {
        if (!layout_.Has(x, y)) continue;
        const float below = sensor.z() - cells_[layout_.At(x, y)].lowest_m;
        if (below > kLowestSensorM && below < kHighestSensorM) around.push_back(-below);
      }
    }
    if (!around.empty()) heights.push_back(-ShareOf(&around, kOfGround));
  }
  return heights.empty() ? kUnknownSensorHeightM : ShareOf(&heights, 0.5);
}

// From the sensors' cells to the next ones and so on: a cell's lowest point is on the ground where
// it is about as high as the ground of the cell before; else the ground goes on level.
void GroundGrid::Grow(std::span<const Eigen::Vector3f> sensors) {
  const float height = SensorHeight(sensors);
  const float step = kGroundStepM * layout_.edge_m / static_cast<float>(kTerrainCellM);
  std::deque<Eigen::Vector2i> next;
  const auto settle = [&](const Eigen::Vector2i& at, float expected, const Cell& before) {
    Cell& cell = cells_[layout_.At(at.x(), at.y())];
    if (cell.steps >= 0) return;
    const bool is_seen = std::abs(cell.lowest_m - expected) < step;
    cell.ground_m = is_seen ? cell.lowest_m : expected;
    cell.guessed = is_seen ? 0 : before.guessed + 1;
    cell.sensor_m = before.sensor_m;
    cell.steps = before.steps + 1;
    next.push_back(at);
  };
  for (const Eigen::Vector3f& sensor : sensors) {
    settle(layout_.Find(sensor), sensor.z() - height, {.sensor_m = sensor.z(), .steps = -1});
  }
  if (next.empty()) {
    const auto lowest =
        std::min_element(cells_.begin(), cells_.end(),
                         [](const Cell& l, const Cell& r) { return l.lowest_m < r.lowest_m; });
    const auto at = static_cast<int>(lowest - cells_.begin());
    settle({at % layout_.width, at / layout_.width}, lowest->lowest_m,
           {.sensor_m = lowest->lowest_m + height, .steps = -1});
  }
  while (!next.empty()) {
    const Eigen::Vector2i at = next.front();
    next.pop_front();
    const Cell from = cells_[layout_.At(at.x(), at.y())];
    for (const Eigen::Vector2i& way : {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1),
                                       Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)}) {
      const Eigen::Vector2i to = at + way;
      if (layout_.Has(to.x(), to.y())) settle(to, from.ground_m, from);
    }
  }
}

const GroundGrid::Cell& GroundGrid::At(const Eigen::Vector3f& p) const {
  const Eigen::Vector2i at = layout_.Find(p);
  return cells_[layout_.At(at.x(), at.y())];
}

float GroundGrid::LowestWithin(int at_x, int at_y, int cells) const {
  float lowest = kNone;
  for (int y = at_y - cells; y <= at_y + cells; ++y) {
    for (int x = at_x - cells; x <= at_x + cells; ++x) {
      if (layout_.Has(x, y)) lowest = std::min(lowest, cells_[layout_.At(x, y)].lowest_m);
    }
  }
  return lowest;
}

}  // namespace isthmus::classes
