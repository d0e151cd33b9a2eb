// A simulated robot's drive, as its odometry mapped it, with the truth beside it.
#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/map/composed_map.h"
#include "core/map/submap.h"
#include "lab/bench/merging/drive_options.h"

namespace isthmus::bench {

// Points of people and cars alone are brighter, with simulation::Truth::kMoving.
inline constexpr float kMovingIntensity = 254.5f;

struct MappedDrive {
  std::vector<std::shared_ptr<const Submap>> submaps;  // The first segment's.
  std::vector<Pose> T_world_submap;                    // The true pose of each.
};

// Session and robot are called after `name`. Errors as SimulateDrive; NotFound for a sensor that
// the odometry does not know.
absl::StatusOr<MappedDrive> MapDrive(const DriveOptions& options, const std::string& name);

// All robots of a world. The submaps lie where they were in truth: errors of placement are not what
// is measured.
struct MappedTeam {
  std::vector<PlacedSubmap> placed;
  std::map<SubmapId, std::shared_ptr<const Submap>> content;

  SubmapReader reader() const {  // Refers to the team.
    return [this](const SubmapId& id) { return content.at(id); };
  }
};

// Robots are called robot_0 and so on. Errors as MapDrive.
absl::StatusOr<MappedTeam> MapTeam(DriveOptions options);

}  // namespace isthmus::bench
