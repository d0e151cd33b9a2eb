#include "server/matching/prepared/looks.h"

#include <algorithm>

#include "server/matching/prepared/limits.h"

namespace isthmus::matching {
namespace {

Look LookAt(const Eigen::Vector3f& point, const RangeImage& image) {
  const float range = point.norm();
  if (range < kMinLookM || range > kMaxLookM) return Look::kNone;
  RangeImage::Interval seen;
  if (!image.At(point, &seen)) return Look::kNone;
  const float margin =
      static_cast<float>(kFreeSpaceMarginM) + static_cast<float>(kFreeSpaceMarginPerM) * range;
  if (range < seen.shortest - margin) return Look::kThrough;
  // Between the two, at an edge of depth, there is no telling which of them it is.
  return range < seen.longest + margin ? Look::kOn : Look::kNone;
}

}  // namespace

std::vector<Look> LookAt(const std::vector<Eigen::Vector3f>& points, const PreparedSubmap& later,
                         const Pose& T_later_older) {
  std::vector<Look> looks(points.size(), Look::kNone);
  for (const PreparedSubmap::View& view : later.views()) {
    const Pose T_sensor_older = view.T_submap_sensor.Inverse() * T_later_older;
    const Eigen::Matrix3f R = T_sensor_older.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_sensor_older.translation().cast<float>();
    for (size_t i = 0; i < points.size(); ++i) {
      if (looks[i] == Look::kOn) continue;
      const Look look = LookAt(R * points[i] + t, view.image);
      if (look != Look::kNone) looks[i] = look;
    }
  }
  return looks;
}

}  // namespace isthmus::matching
