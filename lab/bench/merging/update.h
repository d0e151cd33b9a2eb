// The cost of estimating a pair again after one more submap.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

struct UpdateTrial {
  std::string scenario;
  double all_ms = 0;  // The first estimation, of all but the last submaps of the last robot.
  // One per submap added after that: of those that came when a match of the last robot had been
  // accepted, and of those that came before. Wall times of the estimation alone.
  std::vector<double> accepted_ms, open_ms;
};

// Submaps of the last robot that are added one by one.
inline constexpr size_t kUpdates = 3;

// Robots before the last have finished. The last uploads its submaps but the last kUpdates, then
// these one by one, waiting until the server is idle after each. FailedPrecondition if it has no
// more than kUpdates.
absl::StatusOr<UpdateTrial> RunUpdates(std::vector<DrivenRobot> robots,
                                       const server::PipelineOptions& options);

// Markdown, a row per scenario.
std::string UpdateTable(const std::vector<UpdateTrial>& trials);

}  // namespace isthmus::bench
