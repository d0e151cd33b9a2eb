// A session's map as a surface: thinned to one point per voxel, each with a normal turned to where
// the sensor stood.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/submap.h"

namespace isthmus::matching {

struct SurfacePoint {
  Eigen::Vector3f position;  // Odom frame.
  Eigen::Vector3f normal;    // Unit length, odom frame, towards the sensor.
  float roughness = 1;       // Smallest over middle eigenvalue of the neighbourhood, [0, 1].
};

// Means of the points of all submaps per voxel, in order of first appearance, with normals from the
// eigenvectors of their nearest neighbours' scatter. Drops what has no surface: isolated points and
// lines (a single ring of a spinning LiDAR), non-finite points, points whose keyframe does not
// exist, points farther than 100 km from the origin.
std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m);

}  // namespace isthmus::matching
