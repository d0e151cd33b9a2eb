// An odometry's way laid on its fixes: the heading of its frame, and fixes that are wild.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace isthmus::georeference {

// A place of the antenna as a fix tells it, and the sensor's pose then.
struct AntennaPlace {
  Pose T_level_sensor;     // In a frame of the odometry's whose z is up.
  Eigen::Vector3d in_map;  // Metres.
  double sigma_xy_m = 1;   // Above 0.
};

// From the level frame to the map, in the plane.
struct WayOnFixes {
  double turn_rad = 0;
  double sigma_rad = 1e9;  // The turn's: from the fixes and kHeadingDriftRad.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  // Per place: true if it is so far from the way that its fix must be wrong, see kWildSigmas.
  std::vector<bool> is_wild;
};

// The turn and shift by which the places seen from the odometry, `antenna` off the sensor (m, in
// its frame), lie on those of the fixes: least squares in the plane and without scale (Umeyama,
// "Least-squares estimation of transformation parameters between two point patterns", 1991),
// weighted anew by how far each misses (Cauchy's weights), so that a few wild ones do not turn it.
// The turn is hardly known, with a great sigma, where the places are too near to each other to
// tell, and none is called wild where there are fewer than kLeastPlaces.
WayOnFixes LayOnFixes(const std::vector<AntennaPlace>& places, const Eigen::Vector3d& antenna);

}  // namespace isthmus::georeference
