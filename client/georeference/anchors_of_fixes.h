// Anchors from what a GNSS receiver measured during a drive.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "client/readers/recording.h"
#include "core/map/anchor.h"
#include "core/map/datum.h"
#include "core/map/submap.h"

namespace isthmus::georeference {

struct FixedAnchors {
  // As given; else the first of the fixes in time, with x east and y north: to be set.
  Datum datum;
  bool is_new_datum = false;
  // One for each submap that was begun while there were fixes, in the order of the submaps: the
  // position at its first stamp, between the fixes before and after it where these are at most
  // kLongestGapS apart, else at the nearest one within that. No rotation. The sigma of the
  // horizontal is the larger of east and north; of a fix that states none, limits.h's.
  std::vector<Anchor> anchors;
  int wild = 0;  // Submaps that got none as their fix is far from the way.
};

// The antenna's place on the robot.
struct Antenna {
  Eigen::Vector3d in_sensor = Eigen::Vector3d::Zero();  // Metres, in the LiDAR's frame.
  // Rotation of T_base_sensor: it makes a session's odom frame level.
  Eigen::Quaterniond R_base_sensor = Eigen::Quaterniond::Identity();
};

// `fixes` in any order, on the clock of the submaps' stamps; of several with one stamp the last
// counts. Where the antenna is off the LiDAR, what it is off by is taken out of the positions by
// how each session's way lies on its fixes; until that tells the heading, only its height is, and
// sigma grows by the rest. Fixes that are far from where that way leads are left out. Submaps
// farther than kMaxAnchorM from the datum get none. InvalidArgument where a fix or the datum is out
// of range; NotFound where there are no fixes at all.
absl::StatusOr<FixedAnchors> AnchorsOfFixes(std::vector<readers::GnssFix> fixes,
                                            const std::vector<SubmapInfo>& submaps,
                                            const std::optional<Datum>& datum,
                                            const Antenna& antenna = {});

}  // namespace isthmus::georeference
