// Tells what the points of a cloud are of: ground, walls, poles ...
//
// Geometry alone: eigenvalue features at several scales (Weinmann et al. 2015; Thomas et al.,
// "Semantic classification of 3D point clouds with multiscale spherical neighborhoods", 3DV 2018),
// height above a ground that is followed from below the sensors, columns, and the courses that
// obstacles stand in, told by a random forest. Intensity says nothing: every sensor has its own.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/map/point_class.h"
#include "server/classes/forest.h"

namespace isthmus::classes {

struct PointLabel {
  PointClass of = PointClass::kUnknown;  // Unknown where the likeliest is improbable.
  PointClass likeliest = PointClass::kUnknown;
  float probability = 0;  // The likeliest class's, [0, 1].
};

// Labels in order of the points, which lie in one frame and are thinned to 0.1 m or so. `sensors`:
// places from which they were seen; `up`: about the upward direction. All values are finite.
// `ends_at(i)` is asked before the i-th point, once for each part of the work; nothing comes where
// it says so. The same on every machine whose floats are rounded alike. Thread safe.
std::optional<std::vector<PointLabel>> Classify(
    std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> sensors,
    const Eigen::Vector3f& up, const Forest& forest,
    const std::function<bool(size_t i)>& ends_at = [](size_t) { return false; });

}  // namespace isthmus::classes
