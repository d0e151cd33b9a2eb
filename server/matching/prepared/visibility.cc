#include "server/matching/prepared/visibility.h"

#include <algorithm>

#include "server/matching/prepared/limits.h"

namespace isthmus::matching {
namespace {

Visibility VisibilityOf(const Eigen::Vector3f& point, const RangeImage& image) {
  const float range = point.norm();
  if (range < kMinLookM || range > kMaxLookM) return Visibility::kNone;
  RangeImage::Interval seen;
  if (!image.At(point, &seen)) return Visibility::kNone;
  const float margin =
      static_cast<float>(kFreeSpaceMarginM) + static_cast<float>(kFreeSpaceMarginPerM) * range;
  if (range < seen.shortest - margin) return Visibility::kThrough;
  // Between the two, at an edge of depth, there is no telling which of them it is.
  return range < seen.longest + margin ? Visibility::kOn : Visibility::kNone;
}

}  // namespace

std::vector<Visibility> VisibilityOf(const std::vector<Eigen::Vector3f>& points,
                                     const PreparedSubmap& later, const Pose& T_later_older) {
  std::vector<Visibility> visibility_of(points.size(), Visibility::kNone);
  for (const PreparedSubmap::View& view : later.views()) {
    const Pose T_sensor_older = view.T_submap_sensor.Inverse() * T_later_older;
    const Eigen::Matrix3f R = T_sensor_older.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_sensor_older.translation().cast<float>();
    for (size_t i = 0; i < points.size(); ++i) {
      if (visibility_of[i] == Visibility::kOn) continue;
      const Visibility visibility = VisibilityOf(R * points[i] + t, view.image);
      if (visibility != Visibility::kNone) visibility_of[i] = visibility;
    }
  }
  return visibility_of;
}

}  // namespace isthmus::matching
