#include "core/floors/necks.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace isthmus::floors {
namespace {

using CellSet = absl::flat_hash_set<size_t>;

Eigen::Vector2d MiddleOf(const Cell& cell) {
  return {static_cast<double>(cell.x) + 0.5, static_cast<double>(cell.y) + 0.5};
}

// The cells at which two labels touch, of each pair of cells the one that is farther from walls.
std::map<std::pair<int32_t, int32_t>, std::vector<size_t>> Borders(
    const Mask& ground, const std::vector<int32_t>& squares, const std::vector<int32_t>& labels) {
  std::map<std::pair<int32_t, int32_t>, std::vector<size_t>> borders;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0) continue;
    const Cell at = ground.At(i);
    for (const auto& [x, y] : {Cell{at.x + 1, at.y}, Cell{at.x, at.y + 1}}) {
      if (!ground.Has(x, y)) continue;
      const size_t other = ground.Index(x, y);
      if (labels[other] < 0 || labels[other] == labels[i]) continue;
      borders[std::minmax(labels[i], labels[other])].push_back(squares[i] > squares[other] ? i
                                                                                           : other);
    }
  }
  return borders;
}

// Takes the cells that hang together with one out of `left`, and gives the farthest from walls.
size_t TakeWidest(const Mask& ground, const std::vector<int32_t>& squares, size_t first,
                  CellSet* left) {
  constexpr int64_t kGap = 2;  // A border may go to and fro between both sides.
  std::vector<size_t> line{first};
  left->erase(first);
  size_t widest = first;
  for (size_t next = 0; next < line.size(); ++next) {
    const size_t cell = line[next];
    if (squares[cell] > squares[widest]) widest = cell;
    const Cell at = ground.At(cell);
    for (int64_t y = at.y - kGap; y <= at.y + kGap; ++y) {
      for (int64_t x = at.x - kGap; x <= at.x + kGap; ++x) {
        if (ground.Has(x, y) && left->erase(ground.Index(x, y)) > 0) {
          line.push_back(ground.Index(x, y));
        }
      }
    }
  }
  return widest;
}

// The nearest place that is not open, within `reach` cells; with `first`, on the other side of it.
Eigen::Vector2d NearestSolid(const Mask& ground, const Cell& cell, double reach,
                             const Eigen::Vector2d* first) {
  constexpr double kOtherSide = -0.5;  // Cosine.
  const Eigen::Vector2d at = MiddleOf(cell);
  const auto r = static_cast<int64_t>(reach) + 2;
  Eigen::Vector2d nearest = at;
  double best = reach + 2;
  for (int64_t y = cell.y - r; y <= cell.y + r; ++y) {
    for (int64_t x = cell.x - r; x <= cell.x + r; ++x) {
      if (ground.IsOpen(x, y)) continue;
      const Eigen::Vector2d off = MiddleOf({x, y}) - at;
      const double length = off.norm();
      if (length >= best) continue;
      if (first != nullptr && off.dot(*first - at) > kOtherSide * length * (*first - at).norm()) {
        continue;
      }
      best = length;
      nearest = at + off;
    }
  }
  return nearest;
}

}  // namespace

double Neck::Width() const { return std::max(0.0, (ends[1] - ends[0]).norm() - 1); }

std::vector<Neck> FindNecks(const Mask& ground, const std::vector<int32_t>& squares,
                            const std::vector<int32_t>& labels) {
  constexpr double kAcross = 4;  // The other side is no farther, in distances to the first.
  std::vector<Neck> necks;
  for (const auto& [parts, border] : Borders(ground, squares, labels)) {
    CellSet left(border.begin(), border.end());
    for (const size_t cell : border) {
      if (!left.contains(cell)) continue;
      Neck neck{parts.first, parts.second, TakeWidest(ground, squares, cell, &left)};
      neck.square = squares[neck.cell];
      const double half = std::sqrt(neck.square);
      const Cell at = ground.At(neck.cell);
      neck.ends[0] = NearestSolid(ground, at, half, nullptr);
      neck.ends[1] = NearestSolid(ground, at, kAcross * half, neck.ends.data());
      necks.push_back(neck);
    }
  }
  return necks;
}

}  // namespace isthmus::floors
