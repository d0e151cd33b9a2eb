// Changes between two simulated days against what was moved in truth.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <memory>
#include <vector>

#include "core/records/changed_volumes.h"
#include "lab/bench/merging/drive_options.h"
#include "lab/simulation/worlds/another_day.h"
#include "server/composition/changes/changed_points.h"

namespace isthmus::bench {

struct TwoDays {
  std::vector<composition::ComparedSubmap> submaps;  // As they were placed.
  std::vector<Pose> T_world_submap;                  // The true pose of each.
  std::map<SubmapId, std::shared_ptr<const Submap>> content;
  std::vector<simulation::MovedVolume> moved;
};

// The volumes that were moved up to the day of these drives.
absl::StatusOr<std::vector<simulation::MovedVolume>> MovedOf(const DriveOptions& drive);

struct Verdict {
  // Volumes of which one day measured 20 points, in voxels of 0.1 m, and through whose inner half
  // the other sent 20 of its rays.
  int knowable = 0;
  int found = 0;       // Knowable, and 10 points of volumes of the kind are at most 0.3 m away.
  int wrong = 0;       // Volumes most of whose points lie near none that moved.
  double seen_m2 = 0;  // Ground above which both days have points.
};

// Prints what is not found or wrong if `list`.
Verdict Compare(const TwoDays& days, const std::vector<ChangedVolume>& volumes, bool list);

// Points of what came, a hand above the ground, in a map that drops what is gone: those that it
// dropped, and all.
struct CameCounts {
  int64_t dropped = 0, all = 0;
};
absl::StatusOr<CameCounts> CountDropped(const TwoDays& days);

}  // namespace isthmus::bench
