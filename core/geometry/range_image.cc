#include "core/geometry/range_image.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace isthmus {

int RangeImage::Bin(const Eigen::Vector3f& direction) {
  constexpr float kBinRad = 2 * static_cast<float>(M_PI) / kColumns;
  const float elevation = FastAtan2(direction.z(), direction.head<2>().norm());
  const float row = elevation / kBinRad + 0.5f * kRows;
  if (!(row >= 0 && row < kRows)) return -1;
  const float turn = FastAtan2(direction.y(), direction.x()) + static_cast<float>(M_PI);
  const int column = std::min(static_cast<int>(turn / kBinRad), kColumns - 1);
  return static_cast<int>(row) * kColumns + column;
}

RangeImage::RangeImage(const std::vector<Eigen::Vector3f>& points) {
  constexpr float kMaxRangeM = 650;  // Fits 16 bits of centimetres.
  std::vector<uint16_t> low(kBins, UINT16_MAX), high(kBins, 0);
  for (const Eigen::Vector3f& point : points) {
    const float range = point.norm();
    if (!(range > 0.01f && range < kMaxRangeM)) continue;
    const int bin = Bin(point);
    if (bin < 0) continue;
    const auto cm = static_cast<uint16_t>(100 * range);
    low[bin] = std::min(low[bin], cm);
    high[bin] = std::max(high[bin], cm);
  }
  shortest_.assign(low.size(), 0);
  longest_.assign(low.size(), 0);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int bin = row * kColumns + column;
      if (high[bin] == 0) continue;
      uint16_t shortest = UINT16_MAX, longest = 0;
      for (int r = std::max(0, row - 1); r <= std::min(kRows - 1, row + 1); ++r) {
        for (int c = column - 1; c <= column + 1; ++c) {
          const int neighbor = r * kColumns + (c + kColumns) % kColumns;
          shortest = std::min(shortest, low[neighbor]);
          longest = std::max(longest, high[neighbor]);
        }
      }
      shortest_[bin] = std::max<uint16_t>(1, shortest);
      longest_[bin] = longest;
    }
  }
}

bool RangeImage::At(const Eigen::Vector3f& direction, Interval* interval) const {
  if (shortest_.empty()) return false;
  const int bin = Bin(direction);
  if (bin < 0 || shortest_[bin] == 0) return false;
  interval->shortest = 0.01f * static_cast<float>(shortest_[bin]);
  interval->longest = 0.01f * static_cast<float>(longest_[bin]);
  return true;
}

}  // namespace isthmus
