// A simulated robot's drive, as its odometry mapped it, with the truth beside it.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "bench/merging/drive_options.h"
#include "core/map/submap.h"

namespace isthmus::bench {

struct MappedDrive {
  std::vector<std::shared_ptr<const Submap>> submaps;  // Of the first segment.
  std::vector<Pose> T_world_submap;                    // Of each, in truth.
};

// Session and robot are called after `name`. Errors as SimulateDrive; NotFound for a sensor that
// the odometry does not know.
absl::StatusOr<MappedDrive> MapDrive(const DriveOptions& options, const std::string& name);

}  // namespace isthmus::bench
