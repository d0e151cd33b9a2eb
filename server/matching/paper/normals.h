// Normals by principal components of the neighbourhood, turned to where the sensor stood. Turning
// them to the map's origin instead makes two robots describe the same wall differently, and is why
// feature matching between robots usually fails.
#pragma once

#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/registration/voxel_filter.h"

namespace isthmus::matching {

struct OrientedPoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  // Unit length, towards the sensor.
};

// Points with fewer than three neighbours in the radius have no normal and are dropped. May throw
// what PCL throws.
OrientedPoints EstimateNormals(const std::vector<ViewedPoint>& points,
                               const NormalOptions& options);

}  // namespace isthmus::matching
