// Points from a submap's frame to the map's, in floats.
#pragma once

#include "core/pose.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// A pose that is cheap to apply to many points, the same way every time: the tile that a point is
// sorted into is the tile that it is put on. Value type.
class Placer {
 public:
  explicit Placer(const Pose& T_map_submap)
      : rotation_(T_map_submap.RotationMatrix().cast<float>()),
        translation_(T_map_submap.translation().cast<float>()) {}

  Eigen::Vector3f operator()(const WeightedPoint& p) const {
    return rotation_ * Eigen::Vector3f(p.x, p.y, p.z) + translation_;
  }

 private:
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
};

}  // namespace isthmus::composition
