#include "core/floors/simplify.h"

#include <algorithm>
#include <array>
#include <utility>

namespace isthmus::floors {
namespace {

double Turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

double DistanceTo(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                  const Eigen::Vector2d& place) {
  const Eigen::Vector2d along = to - from;
  const double square = along.squaredNorm();
  const double part = square == 0 ? 0 : std::clamp((place - from).dot(along) / square, 0.0, 1.0);
  return (from + part * along - place).norm();
}

// The corner between two that is farthest from the line between these; `first` if none is.
size_t FarthestBetween(const Outline& outline, size_t first, size_t last, double* distance) {
  size_t farthest = first;
  *distance = 0;
  for (size_t i = first + 1; i < last; ++i) {
    const double here = DistanceTo(outline[first], outline[last % outline.size()], outline[i]);
    if (here > *distance) {
      *distance = here;
      farthest = i;
    }
  }
  return farthest;
}

Outline Simpler(const Outline& outline, double tolerance) {
  if (outline.size() < 4) return outline;
  std::vector<uint8_t> kept(outline.size());
  size_t opposite = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const auto off = [&](size_t k) { return (outline[k] - outline[0]).squaredNorm(); };
    if (off(i) > off(opposite)) opposite = i;
  }
  kept[0] = kept[opposite] = 1;
  std::vector<std::pair<size_t, size_t>> stretches = {{0, opposite}, {opposite, outline.size()}};
  while (!stretches.empty()) {
    const auto [first, last] = stretches.back();
    stretches.pop_back();
    double distance = 0;
    const size_t farthest = FarthestBetween(outline, first, last, &distance);
    if (distance <= tolerance) continue;
    kept[farthest] = 1;
    stretches.emplace_back(first, farthest);
    stretches.emplace_back(farthest, last);
  }
  Outline simpler;
  for (size_t i = 0; i < outline.size(); ++i) {
    if (kept[i] != 0) simpler.push_back(outline[i]);
  }
  return simpler;
}

struct Side {
  Eigen::Vector2d from, to;
  size_t outline = 0, number = 0, count = 0;

  double Low() const { return std::min(from.x(), to.x()); }
  double High() const { return std::max(from.x(), to.x()); }
  bool IsBeside(const Side& other) const {
    return outline == other.outline &&
           ((number + 1) % count == other.number || (other.number + 1) % count == number);
  }
};

bool Meet(const Side& a, const Side& b) {
  if (a.IsBeside(b)) return false;
  if (std::max(a.from.y(), a.to.y()) < std::min(b.from.y(), b.to.y()) ||
      std::max(b.from.y(), b.to.y()) < std::min(a.from.y(), a.to.y())) {
    return false;
  }
  return Turn(a.from, a.to, b.from) * Turn(a.from, a.to, b.to) <= 0 &&
         Turn(b.from, b.to, a.from) * Turn(b.from, b.to, a.to) <= 0;
}

}  // namespace

bool Cross(const std::vector<Outline>& outlines) {
  std::vector<Side> sides;
  for (size_t i = 0; i < outlines.size(); ++i) {
    const Outline& each = outlines[i];
    if (each.size() < 3) return true;
    for (size_t k = 0; k < each.size(); ++k) {
      sides.push_back({each[k], each[(k + 1) % each.size()], i, k, each.size()});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.Low() < b.Low(); });
  for (size_t i = 0; i < sides.size(); ++i) {
    for (size_t k = i + 1; k < sides.size() && sides[k].Low() <= sides[i].High(); ++k) {
      if (Meet(sides[i], sides[k])) return true;
    }
  }
  return false;
}

void Simplify(std::vector<Outline>* outlines) {
  for (const double tolerance : {1.5, 0.75}) {
    std::vector<Outline> simpler;
    for (const Outline& outline : *outlines) simpler.push_back(Simpler(outline, tolerance));
    if (Cross(simpler)) continue;
    *outlines = std::move(simpler);
    return;
  }
}

}  // namespace isthmus::floors
