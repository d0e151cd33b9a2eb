#include "floam/scan/neighbourhood.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <bitset>
#include <cmath>

#include "core/geometry/angles.h"
#include "floam/scan/limits.h"

namespace isthmus::floam {
namespace {

bool IsFinite(const RingPoint& p) { return std::isfinite(p.x + p.y + p.z) && p.range > 0; }

}  // namespace

void Neighbourhoods::ChooseCells(const RingScan& scan) {
  constexpr int kCoarseRows = static_cast<int>(kPi / kLargestCellRad + 0.5F),
                kCoarseColumns = 2 * kCoarseRows;
  std::bitset<static_cast<size_t>(kCoarseRows) * kCoarseColumns> seen;
  angles_.resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const RingPoint& p = scan.points[i];
    const float azimuth = FastAtan2(p.y, p.x);
    const float elevation = FastAtan2(p.z, std::sqrt(p.x * p.x + p.y * p.y));
    angles_[i] = {azimuth, elevation};
    if (!IsFinite(p)) continue;
    const int row = static_cast<int>((elevation + kPi / 2) / kLargestCellRad);
    const int column = static_cast<int>((azimuth + kPi) / kLargestCellRad);
    seen.set(std::clamp(row, 0, kCoarseRows - 1) * kCoarseColumns +
             std::clamp(column, 0, kCoarseColumns - 1));
  }
  float area = 0;
  for (int row = 0; row < kCoarseRows; ++row) {
    const float height = std::cos((static_cast<float>(row) + 0.5F) * kLargestCellRad - kPi / 2);
    for (int column = 0; column < kCoarseColumns; ++column) {
      if (seen[row * kCoarseColumns + column]) area += height * kLargestCellRad * kLargestCellRad;
    }
  }
  const float per_point = area / static_cast<float>(std::max<size_t>(scan.points.size(), 1));
  cell_rad_ = std::clamp(std::sqrt(kPointsPerCell * per_point), kSmallestCellRad, kLargestCellRad);
  const float per_cell = cell_rad_ * cell_rad_ / std::max(per_point, 1e-9F);
  stride_ = std::max<size_t>(1, std::lround(per_cell / kPointsPerCell));
  row_begin_.assign(1, 0);
  const int rows = static_cast<int>(std::ceil(kPi / cell_rad_));
  for (int row = 0; row < rows; ++row) {
    const float middle = (static_cast<float>(row) + 0.5F) * cell_rad_ - kPi / 2;
    const float columns = 2 * kPi * std::max(0.F, std::cos(middle)) / cell_rad_;
    row_begin_.push_back(row_begin_.back() + std::max(3, static_cast<int>(columns)));
  }
}

// Entries in order of cells.
void Neighbourhoods::Sort(const RingScan& scan) {
  const int rows = static_cast<int>(row_begin_.size()) - 1;
  cells_.resize(scan.points.size());
  cell_begin_.assign(row_begin_.back() + 1, 0);
  const auto cell_of = [&](size_t i) { return row_begin_[cells_[i].row] + cells_[i].column; };
  for (size_t i = 0; i < scan.points.size(); ++i) {
    if (!IsFinite(scan.points[i])) continue;
    const int row = static_cast<int>((angles_[i].y() + kPi / 2) / cell_rad_);
    cells_[i].row = static_cast<uint16_t>(std::clamp(row, 0, rows - 1));
    const uint32_t columns = row_begin_[cells_[i].row + 1] - row_begin_[cells_[i].row];
    const float turns = (angles_[i].x() + kPi) / (2 * kPi);
    const int column = static_cast<int>(turns * static_cast<float>(columns));
    cells_[i].column = static_cast<uint16_t>(std::clamp(column, 0, static_cast<int>(columns) - 1));
    if (i % stride_ == 0) ++cell_begin_[cell_of(i)];
  }
  uint32_t sum = 0;
  for (uint32_t& begin : cell_begin_) sum += begin, begin = sum;
  entries_.resize(sum);
  // Backwards, so that each cell's entries come in the order of the scan.
  for (size_t i = scan.points.size(); i-- > 0;) {
    const RingPoint& p = scan.points[i];
    if (i % stride_ != 0 || !IsFinite(p)) continue;
    entries_[--cell_begin_[cell_of(i)]] = {p.x, p.y, p.z, p.time};
  }
}

void Neighbourhoods::Build(const RingScan& scan) {
  scan_ = &scan;
  ChooseCells(scan);
  Sort(scan);
}

// Fills near_ with what may belong to the same thing, and beside_ with the rest.
void Neighbourhoods::Gather(const RingPoint& point, const Cell& cell) {
  near_.clear();
  beside_.clear();
  axes_.col(0) = Eigen::Vector3f(point.x, point.y, point.z) / point.range;
  axes_.col(1) = axes_.col(0).unitOrthogonal();
  axes_.col(2) = axes_.col(0).cross(axes_.col(1));
  Eigen::Array4f to_x, to_y, to_z;
  to_x << axes_.row(0).transpose().array(), 0;
  to_y << axes_.row(1).transpose().array(), 0;
  to_z << axes_.row(2).transpose().array(), 0;
  const float per_cell = 1 / cell_rad_;
  const float steepest = kSteepestSlope * cell_rad_ * point.range;
  const int rows = static_cast<int>(row_begin_.size()) - 1;
  const auto own_columns = static_cast<float>(row_begin_[cell.row + 1] - row_begin_[cell.row]);
  const float turns = (static_cast<float>(cell.column) + 0.5F) / own_columns;
  for (int row = std::max(0, cell.row - 1); row <= std::min(rows - 1, cell.row + 1); ++row) {
    const auto columns = static_cast<int>(row_begin_[row + 1] - row_begin_[row]);
    const int column = static_cast<int>(turns * static_cast<float>(columns));
    for (int side = -1; side <= 1; ++side) {
      const uint32_t at = row_begin_[row] + (column + side + columns) % columns;
      for (uint32_t k = cell_begin_[at]; k < cell_begin_[at + 1]; ++k) {
        const Eigen::Array4f& e = entries_[k];
        const Eigen::Array4f q = to_x * e[0] + to_y * e[1] + to_z * e[2];
        if (!(q[0] > 0)) continue;
        const float inverse = 1 / q[0];
        const float y = per_cell * inverse * q[1], z = per_cell * inverse * q[2];
        const float farther = std::abs(q[0] - point.range) - kSurfaceGapM;
        const bool is_near =
            farther < 0 || farther * farther < steepest * steepest * (y * y + z * z);
        (is_near ? near_ : beside_)
            .push_back(
                {{1, y, z, kPlaneTimePerS * (e[3] - point.time)}, point.range * inverse - 1});
      }
    }
  }
}

// With x towards the point: range / x - 1 = a + b y / x + c z / x + d t.
bool Neighbourhoods::FitPlane(const RingPoint& point, Look* look) const {
  const auto count = static_cast<float>(near_.size());
  if (near_.size() < kMinPlaneNeighbours ||
      count < kMinAlikeShare * static_cast<float>(near_.size() + beside_.size())) {
    return false;
  }
  Eigen::Array<float, 4, 4> H = Eigen::Array<float, 4, 4>::Zero();
  Eigen::Array4f g = Eigen::Array4f::Zero();
  float squares = 0;
  for (const Neighbour& n : near_) {
    for (int k = 0; k < 4; ++k) H.col(k) += n.row * n.row[k];
    g += n.row * n.w;
    squares += n.w * n.w;
  }
  H.matrix().diagonal().tail<3>().array() += kPlaneRidge * count;
  const Eigen::Vector4f plane = H.matrix().llt().solve(g.matrix());
  const float ahead = 1 + plane[0];
  const Eigen::Vector2f slope = plane.segment<2>(1) / cell_rad_;
  const float steepness2 = slope.squaredNorm();
  if (!(ahead > 0.5F) || !(steepness2 < kSteepestSlope * kSteepestSlope * ahead * ahead))
    return false;
  const float misfit = std::max(0.F, squares - plane.dot(g.matrix())) / std::max(count - 4, 1.F);
  look->normal = axes_ * Eigen::Vector3f(-ahead, -slope.x(), -slope.y()).normalized();
  // From inverse range to distance off the plane.
  const float incidence = ahead / std::sqrt(ahead * ahead + steepness2);
  look->deviation_m = std::max(std::abs(plane[0]), std::sqrt(misfit)) * point.range * incidence;
  return true;
}

// A strip of neighbours at about the point's range, and nothing nearer: what is near might hide the
// rest of something wide.
bool Neighbourhoods::IsSlim(const RingPoint& point) {
  strip_.clear();
  background_.clear();
  for (const auto* neighbours : {&near_, &beside_}) {
    for (const Neighbour& n : *neighbours) {
      const float farther = point.range / (1 + n.w) - point.range;
      if (farther < -kSlimThicknessM) return false;
      if (farther < kSlimThicknessM) strip_.emplace_back(n.row[1], n.row[2]);
      if (farther > kSlimBehindM) background_.emplace_back(n.row[1], n.row[2]);
    }
  }
  if (strip_.size() < kMinOnSlim || background_.size() < 2 * kMinBesideSlim) return false;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (const Eigen::Vector2f& p : strip_) mean += p;
  mean /= static_cast<float>(strip_.size());
  Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
  for (const Eigen::Vector2f& p : strip_) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> axes(spread);
  const Eigen::Vector2f across = axes.eigenvectors().col(0), along = axes.eigenvectors().col(1);
  float half_width = 0, first = 0, last = 0;
  for (const Eigen::Vector2f& p : strip_) {
    half_width = std::max(half_width, std::abs(across.dot(p - mean)));
    first = std::min(first, along.dot(p - mean));
    last = std::max(last, along.dot(p - mean));
  }
  if (half_width * cell_rad_ * point.range > kSlimHalfWidthM || last - first < kMinSlimLength)
    return false;
  size_t to_one_side = 0, to_other = 0;
  for (const Eigen::Vector2f& p : background_) {
    const float aside = across.dot(p - mean);
    to_one_side += aside > half_width ? 1 : 0;
    to_other += aside < -half_width ? 1 : 0;
  }
  return std::min(to_one_side, to_other) >= kMinBesideSlim;
}

Neighbourhoods::Look Neighbourhoods::At(uint32_t index, float deviation_m) {
  Look look;
  const RingPoint& point = scan_->points[index];
  if (!IsFinite(point)) return look;
  Gather(point, cells_[index]);
  look.neighbours = near_.size() + beside_.size();
  const float most_m = deviation_m + kDeviationPerM * point.range;
  // Something slim may have a flat side.
  if (beside_.size() >= 2 * kMinBesideSlim && IsSlim(point)) {
    look.are = Surroundings::kEdge;
  } else if (FitPlane(point, &look) && look.deviation_m < most_m) {
    look.are = Surroundings::kSurface;
  }
  return look;
}

}  // namespace isthmus::floam
