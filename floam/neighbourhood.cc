#include "floam/neighbourhood.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>

#include "floam/azimuth.h"

namespace isthmus::floam {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kDegree = kPi / 180;

// Density is measured in coarse cells, points per cell are to be so many, cells of these sizes.
constexpr float kCoarse = 3 * kDegree;
constexpr float kPerCell = 2.2F;
constexpr float kLeastCell = 0.8F * kDegree, kMostCell = 3 * kDegree;

// Neighbours whose range differs by more belong to something else: so much, and so much more per
// metre aside, which is what a surface does that is seen at grazing incidence.
constexpr float kGapM = 0.25F;
constexpr float kSteepest = 5;  // Tangent of the angle of incidence.
constexpr size_t kLeastNeighbours = 6;
constexpr float kLeastShare = 0.6F;  // That belong to the same thing.

constexpr float kSlimM = 0.2F;      // Half the width of what is slim, at most.
constexpr float kBehindM = 0.5F;    // And what is beside it is farther by so much.
constexpr size_t kLeastBeside = 2;  // Points on either side.

bool IsFinite(const RingPoint& p) { return std::isfinite(p.x + p.y + p.z) && p.range > 0; }

float ElevationOf(const RingPoint& p) { return FastAtan2(p.z, std::sqrt(p.x * p.x + p.y * p.y)); }

}  // namespace

int Neighbourhoods::RowOf(float elevation) const {
  const int rows = static_cast<int>(row_cell_.size()) - 1;
  return std::clamp(static_cast<int>((elevation + kPi / 2) / cell_rad_), 0, rows - 1);
}

int Neighbourhoods::ColumnOf(float azimuth, int row) const {
  const auto columns = static_cast<int>(row_cell_[row + 1] - row_cell_[row]);
  const float turns = (azimuth + kPi) / (2 * kPi);
  return std::clamp(static_cast<int>(turns * static_cast<float>(columns)), 0, columns - 1);
}

void Neighbourhoods::ChooseCells(const RingScan& scan) {
  constexpr int kRows = 60, kColumns = 120;
  std::bitset<static_cast<size_t>(kRows) * kColumns> seen;
  size_t finite = 0;
  for (const RingPoint& p : scan.points) {
    if (!IsFinite(p)) continue;
    ++finite;
    const int row = static_cast<int>((ElevationOf(p) + kPi / 2) / kCoarse);
    const int column = static_cast<int>((FastAtan2(p.y, p.x) + kPi) / kCoarse);
    seen.set(std::clamp(row, 0, kRows - 1) * kColumns + std::clamp(column, 0, kColumns - 1));
  }
  float area = 0;
  for (int row = 0; row < kRows; ++row) {
    const float height = std::cos((static_cast<float>(row) + 0.5F) * kCoarse - kPi / 2);
    for (int column = 0; column < kColumns; ++column) {
      if (seen[row * kColumns + column]) area += height * kCoarse * kCoarse;
    }
  }
  const float per_point = area / static_cast<float>(std::max<size_t>(finite, 1));
  cell_rad_ = std::clamp(std::sqrt(kPerCell * per_point), kLeastCell, kMostCell);
  const float per_cell = cell_rad_ * cell_rad_ / std::max(per_point, 1e-9F);
  stride_ = std::max<size_t>(1, std::lround(per_cell / kPerCell));
  row_cell_.assign(1, 0);
  const int rows = static_cast<int>(std::ceil(kPi / cell_rad_));
  for (int row = 0; row < rows; ++row) {
    const float middle = (static_cast<float>(row) + 0.5F) * cell_rad_ - kPi / 2;
    const float columns = 2 * kPi * std::max(0.F, std::cos(middle)) / cell_rad_;
    row_cell_.push_back(row_cell_.back() + std::max(3, static_cast<int>(columns)));
  }
}

void Neighbourhoods::Build(const RingScan& scan) {
  ChooseCells(scan);
  cell_of_.clear();
  begin_.assign(row_cell_.back() + 1, 0);
  for (size_t i = 0; i < scan.points.size(); i += stride_) {
    const RingPoint& p = scan.points[i];
    const int row = IsFinite(p) ? RowOf(ElevationOf(p)) : 0;
    const uint32_t cell = row_cell_[row] + (IsFinite(p) ? ColumnOf(FastAtan2(p.y, p.x), row) : 0);
    cell_of_.push_back(cell);
    if (IsFinite(p)) ++begin_[cell];
  }
  uint32_t sum = 0;
  for (uint32_t& begin : begin_) sum += begin, begin = sum;
  entries_.resize(sum);
  // Backwards, so that each cell's entries end up in order.
  for (size_t k = cell_of_.size(); k-- > 0;) {
    const RingPoint& p = scan.points[k * stride_];
    if (IsFinite(p)) entries_[--begin_[cell_of_[k]]] = {p.x, p.y, p.z, p.time};
  }
}

// Fills near_ with what may belong to the same thing, all_ with everything around.
void Neighbourhoods::Gather(const RingPoint& point) {
  near_.clear();
  all_.clear();
  const Eigen::Vector3f ahead = Eigen::Vector3f(point.x, point.y, point.z) / point.range;
  const Eigen::Vector3f left = ahead.unitOrthogonal();
  const Eigen::Vector3f up = ahead.cross(left);
  const float azimuth = FastAtan2(point.y, point.x);
  const int middle = RowOf(ElevationOf(point));
  const int rows = static_cast<int>(row_cell_.size()) - 1;
  for (int row = std::max(0, middle - 1); row <= std::min(rows - 1, middle + 1); ++row) {
    const auto columns = static_cast<int>(row_cell_[row + 1] - row_cell_[row]);
    const int column = ColumnOf(azimuth, row);
    for (int side = -1; side <= 1; ++side) {
      const uint32_t cell = row_cell_[row] + (column + side + columns) % columns;
      for (uint32_t k = begin_[cell]; k < begin_[cell + 1]; ++k) {
        const Entry& e = entries_[k];
        const Eigen::Vector3f q(e.x, e.y, e.z);
        const float x = ahead.dot(q);
        if (!(x > 0)) continue;
        const Neighbour n = {left.dot(q) / x, up.dot(q) / x, x / point.range, e.time - point.time};
        all_.push_back(n);
        const float aside = std::sqrt(n.y * n.y + n.z * n.z);
        if (std::abs(x - point.range) < kGapM + kSteepest * aside * point.range) near_.push_back(n);
      }
    }
  }
}

bool Neighbourhoods::FitPlane(const RingPoint& point, float* deviation_m) const {
  if (near_.size() < kLeastNeighbours ||
      static_cast<float>(near_.size()) < kLeastShare * static_cast<float>(all_.size())) {
    return false;
  }
  // Unknowns of about the same size: slopes per cell, change per tenth of a second.
  const float per_cell = 1 / cell_rad_;
  constexpr float kPerTime = 10;
  constexpr float kRidge = 1e-3F;
  const auto row_of = [&](const Neighbour& n) {
    return Eigen::Vector4f(1, n.y * per_cell, n.z * per_cell, n.time * kPerTime);
  };
  Eigen::Matrix4f H = Eigen::Matrix4f::Zero();
  Eigen::Vector4f g = Eigen::Vector4f::Zero();
  for (const Neighbour& n : near_) {
    const Eigen::Vector4f row = row_of(n);
    H += row * row.transpose();
    g += row / n.x;
  }
  H.diagonal().tail<3>().array() += kRidge * static_cast<float>(near_.size());
  const Eigen::Vector4f plane = H.llt().solve(g);
  const float slope = per_cell * plane.segment<2>(1).norm();
  if (!(plane[0] > 0.5F) || !(slope < kSteepest * plane[0])) return false;
  float sum = 0;
  for (const Neighbour& n : near_) {
    const float off = row_of(n).dot(plane) - 1 / n.x;
    sum += off * off * n.x * n.x * n.x * n.x;
  }
  const float incidence = plane[0] / std::hypot(plane[0], slope);  // Its cosine.
  const float own_m = std::abs(plane[0] - 1) * point.range * incidence;
  const auto freedom = static_cast<float>(std::max<size_t>(near_.size(), 5) - 4);
  *deviation_m = std::max(own_m, std::sqrt(sum / freedom) * point.range * incidence);
  return true;
}

bool Neighbourhoods::IsSlim(const RingPoint&) const { return false; }

Neighbourhoods::Look Neighbourhoods::At(const RingPoint& point, float deviation_m) {
  Look look;
  if (entries_.empty() || !IsFinite(point)) return look;
  Gather(point);
  if (FitPlane(point, &look.deviation_m) && look.deviation_m < deviation_m) {
    look.are = Surroundings::kSurface;
  } else if (IsSlim(point)) {
    look.are = Surroundings::kEdge;
  }
  return look;
}

}  // namespace isthmus::floam
