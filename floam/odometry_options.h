// Settings of the odometry. The defaults suit every sensor and scene tried; none is needed to
// start. A default without a word on its origin is a guess, with no other value recorded; values
// that are no settings are in the folders' limits.h.
#pragma once

#include <Eigen/Geometry>

#include "core/odometry_mode.h"
#include "floam/map/local_map.h"
#include "floam/match/limits.h"
#include "floam/match/scan_matcher.h"
#include "floam/scan/features.h"

namespace isthmus::floam {

struct OdometryOptions {
  OdometryMode mode = OdometryMode::kContinuous;

  FeatureOptions features;
  LocalMapOptions map;
  MatchOptions matching;

  // The difference between the motion within a scan and that between scans (kContinuous): one
  // sigma. 0.1 at first; thousands of matches outweigh either (docs/decisions/0016).
  double speed_change_sigma = 0.05;     // m/s.
  double yaw_rate_change_sigma = 0.05;  // rad/s.
  double tilt_rate_sigma = 0.05;        // rad/s, roll and pitch.

  // A scan is matched if this share of its features found a plane or line ...
  double min_used_share = 0.25;
  int min_used = kMinMatches;
  // ... and lies on it this well on average; see MatchResult::agreement.
  double min_agreement = 0.4;
  // ... and the pose is this near to the prediction, or no farther than the motion so far lets
  // expect; with 0.6 m, at first, a jump between two scans went unseen.
  double max_surprise_m = 0.3;
  double max_surprise_rad = 0.3;

  // Scans go into the map after this much motion, so that standing still does not blur it, and at
  // the start at any rate.
  double map_distance_m = 0.1;
  double map_angle_rad = 0.05;
  int map_first_scans = 10;
  // The map is young until the sensor has been this far from where it began: from one place, what
  // is far shows single rings only, however many scans there are.
  double map_young_distance_m = 1.0;

  // The sensor's mounting on the robot, which stands about level when the session begins: the
  // rotation of T_base_sensor. A robot that was kidnapped is looked for on the level.
  Eigen::Quaterniond R_base_sensor = Eigen::Quaterniond::Identity();

  // True if OdometryResult::undistorted is wanted.
  bool undistort_cloud = true;
};

}  // namespace isthmus::floam
