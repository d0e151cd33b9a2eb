#include "core/floors/hull.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isthmus::floors {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

bool IsInside(const Hull& hull, const Eigen::Vector2d& at) {
  for (size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& next = hull[(i + 1) % hull.size()];
    if (Cross(next - hull[i], at - hull[i]) < 0) return false;
  }
  return true;
}

}  // namespace

Hull HullOf(std::vector<Eigen::Vector2d> points) {
  if (points.size() < 3) return points;
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  Hull hull;
  for (const bool is_upper : {false, true}) {
    if (is_upper) std::reverse(points.begin(), points.end());
    const size_t base = hull.size();
    for (const Eigen::Vector2d& point : points) {
      while (hull.size() >= base + 2 &&
             Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
  }
  return hull;
}

std::vector<Hull> HullsOf(const Mask& ground, const std::vector<int32_t>& labels, size_t count) {
  std::vector<Hull> hulls(count);
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0) continue;
    const Cell at = ground.At(i);
    // Both ends of each stretch of a row.
    const bool is_first = at.x == 0 || labels[i - 1] != labels[i];
    const bool is_last = at.x + 1 == ground.width || labels[i + 1] != labels[i];
    Hull& hull = hulls[static_cast<size_t>(labels[i])];
    const auto x = static_cast<double>(at.x), y = static_cast<double>(at.y);
    if (is_first) hull.emplace_back(x, y), hull.emplace_back(x, y + 1);
    if (is_last) hull.emplace_back(x + 1, y), hull.emplace_back(x + 1, y + 1);
  }
  for (Hull& hull : hulls) hull = HullOf(std::move(hull));
  return hulls;
}

double ShareOf(const Hull& hull, const std::function<bool(const Cell& cell)>& holds) {
  constexpr int kRows = 50;
  Eigen::Vector2d low = hull.front(), high = hull.front();
  for (const Eigen::Vector2d& corner : hull) {
    low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  }
  int inside = 0, held = 0;
  for (int i = 0; i < kRows; ++i) {
    for (int k = 0; k < kRows; ++k) {
      const Eigen::Array2d part = (Eigen::Array2d(i, k) + 0.5) / kRows;
      const Eigen::Vector2d at = low + ((high - low).array() * part).matrix();
      if (!IsInside(hull, at)) continue;
      ++inside;
      if (holds({static_cast<int64_t>(at.x()), static_cast<int64_t>(at.y())})) ++held;
    }
  }
  return inside == 0 ? 0 : static_cast<double>(held) / inside;
}

}  // namespace isthmus::floors
