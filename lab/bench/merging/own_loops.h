// Loops of a driven robot as the server finds them when the submaps come one by one.
#pragma once

#include <absl/status/status.h>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

// Hands the submaps over to a server of their own and keeps the loops that it finds with the robot.
absl::Status FindOwnLoops(const server::PipelineOptions& options, DrivenRobot* robot);

}  // namespace isthmus::bench
