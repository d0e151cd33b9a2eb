#include "client/offline/merge/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/angles.h"

namespace isthmus::cli {
namespace {

constexpr float kCellRad = 0.01f;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The view from one place: a picture in azimuth and elevation.
class View {
 public:
  View() : depth_(kColumns * kRows), nearest_(kColumns * kRows) {}

  // Indices of the points in sight.
  std::vector<uint32_t> Look(const Cloud& points, const Eigen::Vector3f& from, float spacing_m) {
    std::fill(depth_.begin(), depth_.end(), kInfinity);
    seen_.clear();
    for (uint32_t i = 0; i < points.size(); ++i) {
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
  struct Seen {
    uint32_t index;
    int cell;
    float range;
  };

  // Writes the range where the point hides what is behind it.
  void Cover(int row, int column, float range, float size_rad, float cos_elevation) {
    const int half = std::min(30, static_cast<int>(size_rad / 2 / kCellRad));
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

size_t Nearest(const Trajectory& viewpoints, const Eigen::Vector3d& point) {
  const auto distance = [&](const StampedPose& viewpoint) {
    return (viewpoint.pose.translation() - point).squaredNorm();
  };
  return std::min_element(viewpoints.begin(), viewpoints.end(),
                          [&](const StampedPose& a, const StampedPose& b) {
                            return distance(a) < distance(b);
                          }) -
         viewpoints.begin();
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

std::vector<std::vector<uint32_t>> VisiblePoints(const Cloud& points, const Trajectory& viewpoints,
                                                 double spacing_m) {
  std::vector<std::vector<uint32_t>> visible;
  std::vector<bool> seen(points.size(), false);
  View view;
  for (const StampedPose& viewpoint : viewpoints) {
    visible.push_back(view.Look(points, viewpoint.pose.translation().cast<float>(),
                                static_cast<float>(spacing_m)));
    for (const uint32_t index : visible.back()) seen[index] = true;
  }
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (seen[i]) continue;
    visible[Nearest(viewpoints, points[i].Position().cast<double>())].push_back(i);
  }
  for (std::vector<uint32_t>& indices : visible) std::sort(indices.begin(), indices.end());
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
