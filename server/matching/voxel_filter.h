// Thinning of a whole session's map that keeps in mind from where it was seen.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/submap.h"

namespace isthmus::matching {

struct ViewedPoint {
  Eigen::Vector3f position;   // Odom frame.
  Eigen::Vector3f to_sensor;  // Mean direction to the sensor, odom frame; not of unit length.
};

// The mean of the points of all submaps per voxel, in order of first appearance. Drops non-finite
// points, points whose keyframe does not exist and points farther than 100 km from the origin.
std::vector<ViewedPoint> FilterVoxels(const SessionMap& map, double voxel_m);

}  // namespace isthmus::matching
