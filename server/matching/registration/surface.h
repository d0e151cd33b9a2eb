// Maps as surfaces: thinned to one point per voxel, each with a normal turned to where the sensor
// stood.
#pragma once

#include <Eigen/Core>
#include <stop_token>
#include <vector>

#include "core/map/submap.h"

namespace isthmus::matching {

struct SurfacePoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;  // Unit length, towards the sensor.
  float roughness = 1;     // Smallest over middle eigenvalue of the neighbourhood, [0, 1].
};

// Means of a submap's points per voxel, as FilterVoxels gives them, in the submap frame, with
// normals from the eigenvectors of their nearest neighbours' scatter. Drops what has no surface:
// isolated points and lines (a single ring of a spinning LiDAR). Of more than kMaxSurfaceVoxels
// (limits.h) so many are taken, spread evenly. Nothing once it is told to stop.
std::vector<SurfacePoint> SampleSurface(const Submap& submap, double voxel_m,
                                        const std::stop_token& stop = {});

// The same of a whole session's map, in the odom frame.
std::vector<SurfacePoint> SampleSurface(const SessionMap& map, double voxel_m);

// A surface of a part of a map, and where it lies in the whole.
struct SurfacePart {
  const std::vector<SurfacePoint>* points = nullptr;
  Pose T_whole_part;
};

// All parts in one frame, thinned to one point per voxel: the mean of those whose normals agree
// with the first one's. `*voxel_m` is made as much larger as it takes to come down to about
// `max_points`; 0 for no limit.
std::vector<SurfacePoint> JoinSurfaces(const std::vector<SurfacePart>& parts, size_t max_points,
                                       double* voxel_m);

}  // namespace isthmus::matching
