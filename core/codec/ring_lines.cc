#include "core/codec/ring_lines.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace isthmus::codec {
namespace {

constexpr float kMinRange_m = 1e-3f;
constexpr float kMaxRange_m = 1e5f;

// Rings that odometry supports; a line more of them is none.
constexpr uint32_t kMostLines = 1024;
// Points that are looked at: 16 on each of so many lines.
constexpr uint64_t kLineSamples = 16'384;
// Points by which a line is judged at least: three always lie in a plane.
constexpr double kLeastOnLine = 6;
// Thickness of lines by that of all points up to which they are rings. Rings of a recorded VLP-16
// and of simulated ones, OS0s, OS1s and HDL-64s give less than 0.001. Beams that start off the axis
// make rings thicker where ranges differ: 16 to 40 mm (Ouster's OS1 and OS0, RoboSense's lenses)
// give 0.001 in a room of 4 m x 4 m, and 0.01 to 0.02 within 0.5 m of a wall. Angles of beams
// alone, as Hesai's, give 0. Rows that hold whole firings give 1.
constexpr double kMostThickness = 0.3;

// Spread of lines by that of all points from which on they are rings, which sweep what the cloud
// does. Rings of domes (0 to 90 deg) give 0.8, of a view of 15 deg x 25 deg 0.26; rows of a sixth
// of a turn, with all elevations, give 0.1, and thinner ones less. Wider ones are thick.
constexpr double kLeastSweep = 0.2;

// Sums over the directions of points.
struct Directions {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();

  void Add(const Eigen::Vector3d& direction) {
    ++count;
    sum += direction;
    outer += direction * direction.transpose();
  }
  // Mean square distance from their mean.
  double Spread() const { return 1 - (sum / count).squaredNorm(); }
  // The same from the plane that fits best.
  double Thickness() const {
    const Eigen::Vector3d mean = sum / count;
    const Eigen::Matrix3d spread = outer / count - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(spread, Eigen::EigenvaluesOnly);
    return std::max(0.0, solver.eigenvalues()[0]);
  }
};

struct Fit {
  bool are_rings = false;
  double narrowness = 1;  // 0: lines sweep all around; 1: each has one direction.
};

Fit FitLines(const std::vector<Directions>& lines, const Directions& all) {
  double judged = 0, thickness = 0, spread = 0, narrowness = 0;
  for (const Directions& line : lines) {
    if (line.count < kLeastOnLine) continue;
    judged += line.count;
    thickness += line.count * line.Thickness();
    spread += line.count * line.Spread();
    narrowness += line.sum.norm();
  }
  Fit fit;
  if (judged < 0.5 * all.count || judged == 0) return fit;
  fit.are_rings = thickness / judged <= kMostThickness * kMostThickness * all.Thickness() &&
                  spread / judged >= kLeastSweep * all.Spread();
  fit.narrowness = narrowness / judged;
  return fit;
}

}  // namespace

bool IsReturn(const ScanPoint& p) {
  const float squared = p.x * p.x + p.y * p.y + p.z * p.z;
  return squared >= kMinRange_m * kMinRange_m && squared <= kMaxRange_m * kMaxRange_m;
}

std::optional<RingLines> FindRingLines(uint32_t width, uint32_t height,
                                       const std::vector<ScanPoint>& points) {
  const uint64_t n = points.size();
  if (width < 2 || height < 2 || n != uint64_t{width} * height) return std::nullopt;
  std::vector<Directions> rows(height <= kMostLines ? height : 0);
  std::vector<Directions> columns(width <= kMostLines ? width : 0);
  Directions all;
  // Steps of the golden section meet all lines alike.
  const uint64_t samples = std::min(n, kLineSamples);
  const auto step =
      samples == n ? 1 : static_cast<uint64_t>(0.6180339887 * static_cast<double>(n)) | 1;
  for (uint64_t k = 0, i = 0; k < samples; ++k, i = (i + step) % n) {
    if (!IsReturn(points[i])) continue;
    const Eigen::Vector3d direction =
        Eigen::Vector3d(points[i].x, points[i].y, points[i].z).normalized();
    all.Add(direction);
    if (!rows.empty()) rows[i / width].Add(direction);
    if (!columns.empty()) columns[i % width].Add(direction);
  }
  if (all.count == 0) return std::nullopt;
  const Fit by_row = FitLines(rows, all), by_column = FitLines(columns, all);
  if (by_row.are_rings && (!by_column.are_rings || by_row.narrowness <= by_column.narrowness)) {
    return RingLines{true, height};
  }
  return by_column.are_rings ? std::optional(RingLines{false, width}) : std::nullopt;
}

}  // namespace isthmus::codec
