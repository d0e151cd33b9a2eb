// Volumes of the map that came and went between an earlier state of it and now.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"
#include "core/map/map_name.h"
#include "core/pose.h"
#include "core/records/map_reading.h"

namespace isthmus {

// Something that stands there now and did not (came), or did and does not any more (went).
struct ChangedVolume {
  bool came = false;
  Pose T_map_box;                                  // An upright box around it: of its middle, ...
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // ... and whole edges, x the longer of two.
  uint64_t points = 0;                             // Points of the map's voxels.
  double probability = 0;                          // Probability of the change, by Bayes' rule.
  int64_t seen_first_ns = 0, seen_last_ns = 0;     // When it was seen.
  // When it was not there: went, the first time after; came, the last time before.
  int64_t missing_ns = 0;
  // Sorted: the first that saw each point, and who looked through one first, or of what came last.
  std::vector<RobotId> seen_by, missed_by;
  std::vector<Eigen::Vector3f> places;  // Positions of the points, map frame; only if asked for.
};

struct ChangeQuery {
  // One of the two. Scans before that time are compared with the ones since ...
  std::optional<int64_t> since_ns = {};
  // ... or the submaps that were in the map at that revision with those that came later.
  std::optional<int64_t> since_revision = {};
  MapName component = {};
  std::optional<Box> box = {};  // Map frame; of box, sphere and shape one at most.
  std::optional<RegionQuery::Sphere> sphere = {};
  RegionShape shape = {};
  double smallest_m = 0.3;      // Least length of a volume's longest edge.
  uint32_t max_volumes = 1000;  // The largest; 10,000 at most.
  bool wants_points = false;
};

struct ChangeList {
  int64_t revision = 0;  // Revision of the map that was compared with the past.
  uint64_t submaps_before = 0, submaps_after = 0;
  uint64_t left_out = 0;                    // Volumes beyond max_volumes.
  std::vector<ChangedVolume> volumes = {};  // The largest first.
};

}  // namespace isthmus
