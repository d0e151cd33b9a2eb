#include "floam/scan/scan_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/voxel_thinner.h"
#include "floam/scan/limits.h"

namespace isthmus::floam {
namespace {

int ColumnOf(float x, float y) {
  constexpr float kPerRad = static_cast<float>(ScanImage::kColumns / (2 * std::numbers::pi));
  const int column = static_cast<int>((std::atan2(y, x) + std::numbers::pi_v<float>)*kPerRad);
  return std::min(column, ScanImage::kColumns - 1);
}

}  // namespace

void ScanImage::Make(const RingScan& scan) {
  struct Ring {
    float elevation;
    uint32_t begin, end;
  };
  std::vector<Ring> rings;
  for (size_t k = 0; k + 1 < scan.ring_begin.size(); ++k) {
    const uint32_t begin = scan.ring_begin[k], end = scan.ring_begin[k + 1];
    double sum = 0;
    int count = 0;
    for (uint32_t i = begin; i < end; i += 8) {
      const RingPoint& p = scan.points[i];
      sum += std::atan2(p.z, std::hypot(p.x, p.y));
      ++count;
    }
    if (count > 0) rings.push_back({static_cast<float>(sum / count), begin, end});
  }
  std::sort(rings.begin(), rings.end(),
            [](const Ring& a, const Ring& b) { return a.elevation < b.elevation; });
  pixels_.assign(rings.size() * kColumns, Pixel());
  elevations_.clear();
  for (const Ring& ring : rings) {
    Pixel* const row = pixels_.data() + elevations_.size() * kColumns;
    elevations_.push_back(ring.elevation);
    for (uint32_t i = ring.begin; i < ring.end; ++i) {
      const RingPoint& p = scan.points[i];
      Pixel& pixel = row[ColumnOf(p.x, p.y)];
      pixel.max_range = std::max(pixel.max_range, p.range);
      if (pixel.min_range > 0 && pixel.min_range <= p.range) continue;
      pixel.min_range = p.range;
      pixel.nearest = p.Position();
    }
  }
}

std::vector<Eigen::Vector2f> ScanImage::Walls(const Eigen::Matrix3f& R_level_sensor,
                                              float spacing_m, float max_range_m) const {
  std::vector<Eigen::Vector2f> walls;
  VoxelThinner thinner(spacing_m);
  const size_t step = std::max<size_t>(1, elevations_.size() / kRingsCompared);
  for (size_t ring = 0; ring + step < elevations_.size(); ++ring) {
    for (int column = 0; column < kColumns; ++column) {
      const Pixel& low = At(ring, column);
      const Pixel& high = At(ring + step, column);
      if (low.min_range <= 0 || high.min_range <= 0) continue;
      const Eigen::Vector3f a = R_level_sensor * low.nearest, b = R_level_sensor * high.nearest;
      const float rise = std::abs(b.z() - a.z());
      if (rise < kMinWallRiseM || (b - a).head<2>().norm() > kMaxWallLean * rise) continue;
      if (a.head<2>().squaredNorm() > max_range_m * max_range_m) continue;
      if (thinner.Insert(a.x(), a.y(), 0)) walls.emplace_back(a.head<2>());
    }
  }
  return walls;
}

ScanImage::Sight ScanImage::SightOf(const Eigen::Vector3f& point) const {
  const float elevation = std::atan2(point.z(), point.head<2>().norm());
  const auto above = std::lower_bound(elevations_.begin(), elevations_.end(), elevation);
  if (above == elevations_.begin() || above == elevations_.end()) return Sight::kUnknown;
  const auto upper = static_cast<size_t>(above - elevations_.begin());
  const float apart = elevations_[upper] - elevations_[upper - 1];
  const float to_upper = elevations_[upper] - elevation;
  size_t ring = upper;
  if (to_upper > kSightRingReach * apart) {
    if (apart - to_upper > kSightRingReach * apart) return Sight::kUnknown;
    ring = upper - 1;
  }
  const Pixel& pixel = At(ring, ColumnOf(point.x(), point.y()));
  if (pixel.min_range <= 0) return Sight::kUnknown;
  const float range = point.norm();
  const float tolerance = kSightToleranceM + kSightTolerancePerM * range;
  if (range < pixel.min_range - tolerance) return Sight::kThrough;
  return range > pixel.max_range + tolerance ? Sight::kHidden : Sight::kOnto;
}

}  // namespace isthmus::floam
