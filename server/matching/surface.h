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

// Means of the points of all submaps per voxel, as FilterVoxels gives them, with normals from the
// eigenvectors of their nearest neighbours' scatter. Drops what has no surface: isolated points and
// lines (a single ring of a spinning LiDAR).
std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m);

// The same with `*voxel_m` made as much larger as it takes to come down to about `max_points`; 0
// for no limit.
std::vector<SurfacePoint> SampleSurface(const SessionMap& map, size_t max_points, double* voxel_m);

}  // namespace isthmus::matching
