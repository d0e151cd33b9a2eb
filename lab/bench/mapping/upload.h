// Robots that have their own SLAM and hand over finished submaps, one at a time.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <string>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline.h"

namespace isthmus::bench {

// Opens a session for the robot under this name; the robot is called after it from then on.
absl::Status OpenSession(const std::string& name, server::Pipeline& pipeline, DrivenRobot* robot);

// Hands over one submap and waits until the map has settled.
absl::Status Upload(const Submap& submap, server::Pipeline& pipeline);

// All submaps of robots whose sessions are open, in the order in which they were finished, each
// when the map has settled after the one before. `worst_ms`, if given, becomes the longest that one
// of them took, wall time.
absl::Status UploadAll(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                       double* worst_ms = nullptr);

// Finishes their sessions and waits until the map has settled.
absl::Status FinishAll(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline);

}  // namespace isthmus::bench
