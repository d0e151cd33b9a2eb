#include "server/composition/visibility/submap_views.h"

#include "server/composition/visibility/limits.h"

namespace isthmus::composition {

size_t SubmapViews::bytes() const {
  return sizeof(SubmapViews) +
         views.size() * (sizeof(View) + 2 * RangeImage::kBins * sizeof(uint16_t));
}

SubmapViews MakeViews(const Submap& submap) {
  SubmapViews made;
  std::vector<Eigen::Vector3f> points;
  size_t begin = 0;
  const size_t step = (submap.keyframes.size() + kMostViews - 1) / kMostViews;
  for (size_t k = 0; k < submap.keyframes.size(); ++k) {
    const Pose& T_submap_sensor = submap.keyframes[k].T_submap_sensor;
    const Pose T_sensor_submap = T_submap_sensor.Inverse();
    const Eigen::Matrix3f R = T_sensor_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_sensor_submap.translation().cast<float>();
    points.clear();
    const bool is_taken = k % step == 0;
    for (; begin < submap.points.size() && submap.points[begin].keyframe <= k; ++begin) {
      if (is_taken) points.push_back(R * submap.points[begin].Position() + t);
    }
    if (points.empty() || !T_submap_sensor.IsFinite()) continue;
    made.views.push_back({T_submap_sensor, static_cast<uint16_t>(k), RangeImage(points)});
  }
  return made;
}

}  // namespace isthmus::composition
