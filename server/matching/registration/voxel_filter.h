// Thinning of submaps that keeps in mind from where they were seen.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/map/submap.h"

namespace isthmus::matching {

struct ViewedPoint {
  Eigen::Vector3f position;
  Eigen::Vector3f to_sensor;  // Mean direction to the sensor; not of unit length.
};

// The mean of the points of all submaps per voxel, odom frame, in order of first appearance. Drops
// non-finite points, points whose keyframe does not exist and points farther than 100 km from the
// origin.
std::vector<ViewedPoint> FilterVoxels(const SessionMap& map, double voxel_m);

// The same of one submap, in its own frame.
std::vector<ViewedPoint> FilterVoxels(const Submap& submap, double voxel_m);

}  // namespace isthmus::matching
