// The heading of an odometry's frame, by the fixes on its way.
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

// Turn about z from the level frame to the map.
struct Heading {
  double rad = 0;
  double sigma_rad = 1e9;  // Of the fixes and kHeadingDriftRad.
};

// The turn by which the places seen from the odometry, `antenna` off the sensor (m, in its frame),
// lie on those of the fixes with the least weighted squares (Umeyama, "Least-squares estimation of
// transformation parameters between two point patterns", 1991, in the plane and without scale).
// Hardly known, with a great sigma, where the places are too near to each other to tell.
Heading HeadingOf(const std::vector<AntennaPlace>& places, const Eigen::Vector3d& antenna);

}  // namespace isthmus::georeference
