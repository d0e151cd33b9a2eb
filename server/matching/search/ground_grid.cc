#include "server/matching/search/ground_grid.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "server/matching/search/limits.h"

namespace isthmus::matching {

GroundGrid::GroundGrid(const std::vector<SurfacePoint>& surface, double cell_m)
    : cell_m_(static_cast<float>(cell_m)) {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector2f high = -low;
  for (const SurfacePoint& point : surface) {
    if (point.normal.z() < kMinLevelNormalZ) continue;
    low = low.cwiseMin(point.position.head<2>());
    high = high.cwiseMax(point.position.head<2>());
  }
  if (low.x() > high.x()) return;
  const Eigen::Vector2f size = (high - low) / cell_m_;
  if (!((size.x() + 1) * (size.y() + 1) < kMaxPlanCells)) return;
  origin_ = low;
  width_ = static_cast<int>(size.x()) + 1;
  rows_ = static_cast<int>(size.y()) + 1;
  height_.assign(static_cast<size_t>(width_) * rows_, std::numeric_limits<float>::max());
  known_.assign(height_.size(), 0);
  for (const SurfacePoint& point : surface) {
    if (point.normal.z() < kMinLevelNormalZ) continue;
    const int cell = Index(point.position.x(), point.position.y());
    height_[cell] = std::min(height_[cell], point.position.z());
    known_[cell] = 1;
  }
  RejectTops();
  Fill();
}

int GroundGrid::Index(float x, float y) const {
  const int column = std::clamp(static_cast<int>((x - origin_.x()) / cell_m_), 0, width_ - 1);
  const int row = std::clamp(static_cast<int>((y - origin_.y()) / cell_m_), 0, rows_ - 1);
  return row * width_ + column;
}

float GroundGrid::Height(float x, float y) const { return empty() ? 0.0f : height_[Index(x, y)]; }

bool GroundGrid::Seen(float x, float y) const {
  if (empty() || x < origin_.x() || y < origin_.y()) return false;
  if (x >= origin_.x() + cell_m_ * static_cast<float>(width_)) return false;
  if (y >= origin_.y() + cell_m_ * static_cast<float>(rows_)) return false;
  return known_[Index(x, y)] != 0;
}

void GroundGrid::RejectTops() {
  const std::vector<char> before = known_;
  std::vector<float> around;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const int cell = row * width_ + column;
      if (!before[cell]) continue;
      around.clear();
      for (int r = std::max(0, row - kTopWindow); r <= std::min(rows_ - 1, row + kTopWindow); ++r) {
        for (int c = std::max(0, column - kTopWindow);
             c <= std::min(width_ - 1, column + kTopWindow); ++c) {
          if (before[r * width_ + c]) around.push_back(height_[r * width_ + c]);
        }
      }
      std::nth_element(around.begin(), around.begin() + around.size() / 2, around.end());
      if (height_[cell] > around[around.size() / 2] + kTopStepM) known_[cell] = 0;
    }
  }
}

void GroundGrid::Fill() {
  std::deque<int> front;
  std::vector<char> filled = known_;
  for (int cell = 0; cell < width_ * rows_; ++cell) {
    if (!known_[cell]) continue;
    front.push_back(cell);
    const float x = origin_.x() + cell_m_ * (static_cast<float>(cell % width_) + 0.5f);
    const float y = origin_.y() + cell_m_ * (static_cast<float>(cell / width_) + 0.5f);
    seen_.push_back({{x, y}, height_[cell]});
  }
  const auto spread = [&](int from, int to) {
    if (filled[to]) return;
    filled[to] = 1;
    height_[to] = height_[from];
    front.push_back(to);
  };
  while (!front.empty()) {
    const int cell = front.front();
    front.pop_front();
    if (cell % width_ > 0) spread(cell, cell - 1);
    if (cell % width_ < width_ - 1) spread(cell, cell + 1);
    if (cell >= width_) spread(cell, cell - width_);
    if (cell < width_ * (rows_ - 1)) spread(cell, cell + width_);
  }
}

}  // namespace isthmus::matching
