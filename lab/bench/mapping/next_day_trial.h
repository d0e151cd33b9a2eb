// A trial of a robot's second day: it should be matched to its map of the day before.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

struct NextDayTrial {
  uint64_t seed = 0;
  bool same_after_restart = false;  // Yesterday's submaps lie where they lay, to a micrometre.
  bool placed = false;              // Today's session is in yesterday's component, ...
  size_t placed_after = 0;          // ... since this submap of today's, counted from 1.
  size_t submaps = 0;               // Today's.
  // In the alignment that yesterday's map has with the truth.
  double yesterday_rmse_m = 0, today_rmse_m = 0, today_worst_m = 0;
};

// Yesterday's robot uploads all, its session is finished and the server ends. Today a server takes
// up the same store, and a session of the same robot uploads the other drive.
absl::StatusOr<NextDayTrial> RunNextDay(DrivenRobot yesterday, DrivenRobot today,
                                        const server::PipelineOptions& options);

}  // namespace isthmus::bench
