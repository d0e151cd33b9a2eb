#include "client/offline/merge/viewpoints.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/geometry/angles.h"

namespace isthmus::cli {
namespace {

constexpr float kCellRad = 0.01f;
constexpr float kMaxSpacingM = 1;
constexpr size_t kSpacingSample = 200;
// A point with fewer points, itself among them, within 1.5 to 3 spacings of the map stands alone: a
// surface has some 9 to 25 there. A guess.
constexpr int kLeastTogether = 4;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The view from one place: a picture in azimuth and elevation.
class View {
 public:
  View() : depth_(kColumns * kRows), nearest_(kColumns * kRows) {}

  // Indices of the points in sight. Those that stand alone are passed over.
  std::vector<uint32_t> Look(const Cloud& points, const std::vector<bool>& alone,
                             const Eigen::Vector3f& from, float spacing_m) {
    std::fill(depth_.begin(), depth_.end(), kInfinity);
    seen_.clear();
    for (uint32_t i = 0; i < points.size(); ++i) {
      if (alone[i]) continue;
      const Eigen::Vector3f ray = points[i].Position() - from;
      const float range = ray.norm();
      if (range > kSightM || range < 0.1f) continue;
      const float azimuth = std::atan2(ray.y(), ray.x());
      const float elevation = std::asin(ray.z() / range);
      const int row = std::min(kRows - 1, static_cast<int>((elevation + kPi / 2) / kCellRad));
      const int column = static_cast<int>((azimuth + kPi) / kCellRad) % kColumns;
      seen_.push_back({i, row * kColumns + column, range});
      Cover(row, column, range, spacing_m / range, std::cos(elevation));
    }
    return InSight();
  }

 private:
  static constexpr int kColumns = 629, kRows = 315;  // 2 pi and pi by kCellRad.
  static constexpr int kMaxHalf = 30;
  struct Seen {
    uint32_t index;
    int cell;
    float range;
  };

  // Writes the range where the point hides what is behind it: in so many cells that points of a
  // surface leave none between them.
  void Cover(int row, int column, float range, float size_rad, float cos_elevation) {
    const int half =
        std::clamp(static_cast<int>(std::ceil((size_rad / kCellRad - 1) / 2)), 0, kMaxHalf);
    const int wide =
        std::min(kColumns / 2, static_cast<int>(half / std::max(cos_elevation, 0.05f)));
    for (int r = std::max(0, row - half); r <= std::min(kRows - 1, row + half); ++r) {
      for (int c = column - wide; c <= column + wide; ++c) {
        float& depth = depth_[r * kColumns + (c + kColumns) % kColumns];
        depth = std::min(depth, range);
      }
    }
  }

  std::vector<uint32_t> InSight() {
    constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
    std::fill(nearest_.begin(), nearest_.end(), kNone);
    for (uint32_t s = 0; s < seen_.size(); ++s) {
      // A surface seen at a slant hides itself a little.
      if (seen_[s].range > depth_[seen_[s].cell] * 1.03f + 0.15f) continue;
      uint32_t& nearest = nearest_[seen_[s].cell];
      if (nearest == kNone || seen_[s].range < seen_[nearest].range) nearest = s;
    }
    std::vector<uint32_t> indices;
    for (const uint32_t s : nearest_) {
      if (s != kNone) indices.push_back(seen_[s].index);
    }
    std::sort(indices.begin(), indices.end());
    return indices;
  }

  std::vector<float> depth_;
  std::vector<uint32_t> nearest_;  // Index into seen_, by cell.
  std::vector<Seen> seen_;
};

// The usual distance of a point from the one nearest to it: the median of a sample.
float Spacing(const Cloud& points) {
  std::vector<float> distances;
  const size_t step = 1 + points.size() / kSpacingSample;
  for (size_t i = 0; i < points.size(); i += step) {
    float nearest2 = kMaxSpacingM * kMaxSpacingM;
    for (size_t k = 0; k < points.size(); ++k) {
      const float distance2 = (points[k].Position() - points[i].Position()).squaredNorm();
      if (k != i) nearest2 = std::min(nearest2, distance2);
    }
    distances.push_back(std::sqrt(nearest2));
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

// The points that stand alone, by their number in voxels and those around.
std::vector<bool> StandAlone(const Cloud& points, float spacing_m) {
  const float edge_m = 1.5f * spacing_m;
  const auto cell_of = [edge_m](const Point& point) -> Eigen::Vector3i {
    return (point.Position() / edge_m).array().floor().cast<int>();
  };
  absl::flat_hash_map<std::array<int, 3>, int> count;
  for (const Point& point : points) {
    const Eigen::Vector3i cell = cell_of(point);
    ++count[{cell.x(), cell.y(), cell.z()}];
  }
  std::vector<bool> alone;
  for (const Point& point : points) {
    const Eigen::Vector3i cell = cell_of(point);
    int together = 0;
    for (int i = 0; i < 27 && together < kLeastTogether; ++i) {
      const auto found =
          count.find({cell.x() + i % 3 - 1, cell.y() + i / 3 % 3 - 1, cell.z() + i / 9 - 1});
      if (found != count.end()) together += found->second;
    }
    alone.push_back(together < kLeastTogether);
  }
  return alone;
}

// The viewpoint nearest to the point, of those with points in sight if there are any.
size_t Nearest(const Trajectory& viewpoints, const std::vector<std::vector<uint32_t>>& visible,
               const Eigen::Vector3d& point) {
  const auto rank = [&](size_t k) {
    return std::pair(visible[2 * k].empty(),
                     (viewpoints[k].pose.translation() - point).squaredNorm());
  };
  size_t nearest = 0;
  for (size_t k = 1; k < viewpoints.size(); ++k) {
    if (rank(k) < rank(nearest)) nearest = k;
  }
  return nearest;
}

}  // namespace

Trajectory Thin(const Trajectory& trajectory, double distance_m) {
  Trajectory out;
  for (const StampedPose& pose : trajectory) {
    if (!out.empty()) {
      const Eigen::Vector3d step = pose.pose.translation() - out.back().pose.translation();
      if (step.norm() < distance_m) continue;
    }
    out.push_back(pose);
  }
  return out;
}

std::vector<std::vector<uint32_t>> VisiblePoints(const Cloud& points,
                                                 const Trajectory& viewpoints) {
  std::vector<std::vector<uint32_t>> visible(2 * viewpoints.size());
  if (points.empty()) return visible;
  const float spacing_m = Spacing(points);
  const std::vector<bool> alone = StandAlone(points, spacing_m);
  std::vector<bool> seen(points.size(), false);
  View view;
  for (size_t k = 0; k < viewpoints.size(); ++k) {
    visible[2 * k] =
        view.Look(points, alone, viewpoints[k].pose.translation().cast<float>(), spacing_m);
    for (const uint32_t index : visible[2 * k]) seen[index] = true;
  }
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (seen[i]) continue;
    visible[2 * Nearest(viewpoints, visible, points[i].Position().cast<double>()) + 1].push_back(i);
  }
  return visible;
}

double NearestM(const Cloud& points, const Trajectory& viewpoints) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const StampedPose& viewpoint : viewpoints) {
    for (const Point& point : points) {
      const Eigen::Vector3d ray = point.Position().cast<double>() - viewpoint.pose.translation();
      nearest_m = std::min(nearest_m, ray.norm());
    }
    if (nearest_m <= kSightM) break;
  }
  return nearest_m;
}

}  // namespace isthmus::cli
