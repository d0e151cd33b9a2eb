// Maps before and after, to look at.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "bench/merging/driven_robot.h"
#include "server/pipeline.h"

namespace isthmus::bench {

// Writes `path`_open.png, the submaps where odometry has them, the first robot's frame for all, and
// `path`_closed.png, the map of the first robot's component. Errors of writing files.
absl::Status DrawOpenAndClosed(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                               const std::string& path);

}  // namespace isthmus::bench
