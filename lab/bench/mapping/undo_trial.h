// A trial of undoing: a person's wrong decisions about a map, taken back.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

enum class UndoBy {
  kUndoRevision,  // The revision that came of the wrong match is undone: the match is rejected.
  kWithdrawing,   // The decision on the pair is taken back: the computed match holds again.
};

struct UndoTrial {
  std::string name;
  uint64_t seed = 0;
  bool merged_before = false;  // A match had been accepted.
  double forced_m = 0;         // Largest move that the wrong match caused within one frame.
  double left_m = 0;           // Largest difference of a position from before, when all is undone.
  double left_deg = 0;         // And of an orientation.
};

// Two robots upload all they have; then a match of the two is set by hand, 5 m and 20 degrees off
// what was found, and that is undone. The robots' newest trajectories in the map are compared, as
// they were before and are after. FailedPrecondition if the wrong match changed nothing.
absl::StatusOr<UndoTrial> RunUndo(std::vector<DrivenRobot> robots, UndoBy how,
                                  const server::PipelineOptions& options);

}  // namespace isthmus::bench
