// A hall that a made-up LiDAR drives through, and things in it that come and go.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {

using Thing = Box;  // A ray may hit it from outside.

inline const Box kGallery = MakeBox({-10, -8, 0}, {10, 8, 4});

// The end of a ray from inside the hall.
inline Eigen::Vector3d End(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                           const std::vector<Thing>& things) {
  const auto slabs = [&](const Box& box) {  // Distances at which the ray enters and leaves.
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      double near = (box.min[axis] - origin[axis]) / direction[axis];
      double far = (box.max[axis] - origin[axis]) / direction[axis];
      if (near > far) std::swap(near, far);
      enter = std::max(enter, near);
      leave = std::min(leave, far);
    }
    return std::pair(enter, leave);
  };
  double range = slabs(kGallery).second;
  for (const Thing& thing : things) {
    const auto [enter, leave] = slabs(thing);
    if (enter < leave) range = std::min(range, enter);
  }
  return origin + range * direction;
}

// The scans of a LiDAR of 16 rings on its way of 4 m, one every half metre. `when` says which
// things are there at the k-th look.
template <typename When>
LaidSubmap Drive(const std::string& robot, uint32_t index, double y, const When& when) {
  constexpr double kDegree = std::numbers::pi / 180;
  LaidSubmap laid = MakeSubmap(robot, index, {});
  auto submap = std::make_shared<Submap>(*laid.submap);
  submap->keyframes.clear();
  submap->first_stamp_ns = submap->last_stamp_ns;
  for (int k = 0; k < 9; ++k) {
    const Eigen::Vector3d sensor(-2.013 + 0.5 * k, y + 0.007, 0.83);
    const int64_t stamp_ns = submap->first_stamp_ns + k * int64_t{1'000'000'000};
    submap->keyframes.push_back({.stamp_ns = stamp_ns, .T_submap_sensor = Pose(sensor)});
    submap->last_stamp_ns = stamp_ns;
    const std::vector<Thing> things = when(k);
    for (int azimuth = 0; azimuth < 720; ++azimuth) {
      for (int ring = 0; ring < 16; ++ring) {
        const double a = (azimuth + 0.3) * 0.5 * kDegree, e = (2 * ring - 15) * kDegree;
        const Eigen::Vector3d p = End(
            sensor, {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)}, things);
        SubmapPoint point = At(p.x(), p.y(), p.z());
        point.keyframe = static_cast<uint16_t>(k);
        submap->points.push_back(point);
      }
    }
  }
  laid.submap = submap;
  return laid;
}

}  // namespace isthmus::composition
