#include "server/matching/index/plan_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

void Enclose(SessionPlan* plan) {
  Eigen::AlignedBox2f box;
  for (const auto& wall : plan->walls) box.extend(wall.position);
  for (size_t i = 0; i < plan->free.size(); ++i) {
    if (plan->free[i]) box.extend(plan->FreeCenter(i));
  }
  if (box.isEmpty()) return;
  plan->center = box.center();
  plan->radius = 0.5f * box.sizes().norm() + plan->cell_m;
}

// The view's range in each direction, of ends at the height of the low layers: medians over its
// rows, 0 if there is none.
using Ranges = std::array<float, RangeImage::kColumns>;

Ranges RangesOf(const RangeImage& image, const Eigen::Matrix3f& R_level_sensor, float eye_m) {
  constexpr float kBinRad = 2 * static_cast<float>(M_PI) / RangeImage::kColumns;
  std::array<std::vector<float>, RangeImage::kColumns> bins;
  for (size_t i = 0; i < image.longest_cm().size(); ++i) {
    // Not the shortest: dust and rain make that one short.
    const uint16_t cm = image.longest_cm()[i];
    if (cm == 0) continue;
    const auto row = static_cast<float>(i / RangeImage::kColumns) + 0.5f;
    const auto column = static_cast<float>(i % RangeImage::kColumns) + 0.5f;
    const float elevation = (row - 0.5f * RangeImage::kRows) * kBinRad;
    const float azimuth = column * kBinRad - static_cast<float>(M_PI);
    const Eigen::Vector3f ray =
        0.01f * static_cast<float>(cm) *
        (R_level_sensor * Eigen::Vector3f(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth),
                                          std::sin(elevation)));
    const float height = eye_m + ray.z() - kPlanLowM;
    if (!(height >= 0 && height < kLowLayers * kLayerM)) continue;
    const float turn = (std::atan2(ray.y(), ray.x()) + static_cast<float>(M_PI)) / kBinRad;
    bins[std::clamp(static_cast<int>(turn), 0, RangeImage::kColumns - 1)].push_back(
        ray.head<2>().norm());
  }
  Ranges ranges = {};
  for (size_t i = 0; i < bins.size(); ++i) {
    if (bins[i].empty()) continue;
    const auto middle = bins[i].begin() + static_cast<std::ptrdiff_t>((bins[i].size() - 1) / 2);
    std::nth_element(bins[i].begin(), middle, bins[i].end());
    ranges[i] = *middle;
  }
  return ranges;
}

}  // namespace

PlanGrid::PlanGrid(const std::vector<Eigen::Vector3f>& sensors) {
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector3f& sensor : sensors) box.extend(sensor.head<2>());
  if (box.isEmpty()) return;
  const Eigen::Vector2f reach = Eigen::Vector2f::Constant(kPlanReachM);
  origin_ = box.min() - reach;
  const Eigen::Vector2f size = box.sizes() + 2 * reach;
  cell_m_ = kPlanCellM;
  while (size.norm() / cell_m_ > kMaxPlanSide) cell_m_ *= 2;
  if (!std::isfinite(cell_m_)) return;
  width_ = static_cast<int>(size.x() / cell_m_) + 1;
  rows_ = static_cast<int>(size.y() / cell_m_) + 1;
  cells_.resize(static_cast<size_t>(width_) * rows_);
}

PlanGrid::Cell* PlanGrid::At(const Eigen::Vector2f& position) {
  const Eigen::Vector2f at = (position - origin_) / cell_m_;
  if (!(at.x() >= 0 && at.y() >= 0)) return nullptr;
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  return x < width_ && y < rows_ ? &cells_[static_cast<size_t>(y) * width_ + x] : nullptr;
}

bool PlanGrid::IsNearBlocking(int x, int y) const {
  for (int v = std::max(0, y - 1); v <= std::min(rows_ - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 1); ++u) {
      if (cells_[static_cast<size_t>(v) * width_ + u].Blocks()) return true;
    }
  }
  return false;
}

void PlanGrid::DrawWalls(const std::vector<SurfacePoint>& surface, const GroundGrid& ground,
                         const std::vector<Eigen::Vector3f>& sensors) {
  for (const SurfacePoint& point : surface) {
    if (std::abs(point.normal.z()) > kMaxWallNormalZ) continue;
    const Eigen::Vector2f at = point.position.head<2>();
    const float height = point.position.z() - ground.Height(at.x(), at.y()) - kPlanLowM;
    if (!(height >= 0 && height < kPlanLayers * kLayerM)) continue;
    bool near = false;
    for (size_t k = 0; k < sensors.size() && !near; k += 3) {
      near = (sensors[k].head<2>() - at).squaredNorm() < kPlanReachM * kPlanReachM;
    }
    Cell* cell = near ? At(at) : nullptr;
    if (cell == nullptr || cell->count == std::numeric_limits<uint16_t>::max()) continue;
    cell->normal += point.normal.head<2>().normalized();
    cell->layers = static_cast<uint16_t>(cell->layers | 1u << static_cast<int>(height / kLayerM));
    ++cell->count;
  }
}

void PlanGrid::DrawFree(const RangeImage& image, const Pose& T_level_sensor,
                        const GroundGrid& ground) {
  const Eigen::Vector3f sensor = T_level_sensor.translation().cast<float>();
  const float eye_m = sensor.z() - ground.Height(sensor.x(), sensor.y());
  const Ranges ranges =
      RangesOf(image, T_level_sensor.RotationMatrix().cast<float>().eval(), eye_m);
  const size_t count = ranges.size();
  for (size_t i = 0; i < count; ++i) {
    // An image's bins say as well what their neighbours do: the least of three is free for sure.
    float range = std::min(ranges[i], kPlanReachM);
    for (const size_t other : {(i + 1) % count, (i + count - 1) % count}) {
      if (ranges[other] > 0) range = std::min(range, ranges[other]);
    }
    const float azimuth = (2 * (static_cast<float>(i) + 0.5f) / static_cast<float>(count) - 1) *
                          static_cast<float>(M_PI);
    const Eigen::Vector2f step = cell_m_ * Eigen::Vector2f(std::cos(azimuth), std::sin(azimuth));
    // Half a metre short of what stopped the ray.
    const int steps = static_cast<int>((range - 0.5f) / cell_m_);
    Eigen::Vector2f at = sensor.head<2>() + 0.5f * step;
    for (int k = 0; k < steps; ++k, at += step) {
      Cell* cell = At(at);
      if (cell != nullptr && cell->hits < std::numeric_limits<uint8_t>::max()) ++cell->hits;
    }
  }
}

SessionPlan PlanGrid::Plan() const {
  SessionPlan plan;
  plan.cell_m = cell_m_;
  plan.origin = origin_;
  plan.width = width_;
  plan.rows = rows_;
  plan.free.resize(cells_.size());
  for (size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    const int x = static_cast<int>(i % width_), y = static_cast<int>(i / width_);
    if (cell.count > 0) {
      const auto low = static_cast<float>(std::popcount(cell.layers & ((1u << kLowLayers) - 1)));
      const auto high = static_cast<float>(std::popcount(cell.layers)) - low;
      const float weight = std::min(1.0f, std::max(low / kFullLow, high / kFullHigh));
      plan.walls.push_back({plan.FreeCenter(i),
                            weight / static_cast<float>(cell.count) * cell.normal, weight,
                            cell.Blocks()});
    } else if (cell.hits >= kFreeHits) {
      plan.free[i] = !IsNearBlocking(x, y);
    }
  }
  Enclose(&plan);
  return plan;
}

}  // namespace isthmus::matching
