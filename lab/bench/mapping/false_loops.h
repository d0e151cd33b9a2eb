// A trial of false loop closures: their effect on a map, at the level of placement, as no robot can
// be made to find them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/loop_closure.h"
#include "lab/bench/merging/driven_robot.h"
#include "server/placement/placer.h"

namespace isthmus::bench {

enum class FalseKind {
  kRandom,  // Any two submaps, a few metres and any turn: none agrees with another.
  kNear,    // A right one, 1 to 4 m and up to 15 degrees off: odometry cannot rule it out.
  kTwins,   // A stretch of submaps lies on another that looks alike: five edges agree.
};

// Appends false closures of the session until they have `share` of all edges. Information is that
// of edges which are there; without any nothing is added. Ids go on from the largest. Returns how
// many edges were added.
size_t AddFalseLoops(FalseKind kind, double share, uint64_t seed, const DrivenRobot& robot,
                     std::vector<LoopClosure>* loops);

struct FalseLoopsTrial {
  std::string name;
  uint64_t seed = 0;
  size_t edges = 0, false_edges = 0;             // Offered, the false ones among them.
  size_t false_kept = 0, right_lost = 0;         // By the placer.
  double open_m = 0, without_m = 0, with_m = 0;  // RMSE over keyframes.
  double without_ms = 0, with_ms = 0;            // CPU of placing at once.
};

// Places the robot's submaps by these closures, without and with false ones.
FalseLoopsTrial RunFalseLoops(const DrivenRobot& robot, const std::vector<LoopClosure>& found,
                              FalseKind kind, double share, uint64_t seed,
                              const placement::PlacerOptions& options);

}  // namespace isthmus::bench
