// Closures by single submaps, where the place of the newest on older ones is known to within what
// an alignment of two submaps captures: a loop that goes on, and steps of a bad odometry.
#pragma once

#include <optional>
#include <vector>

#include "core/map/loop_closure.h"
#include "server/matching/loops/loop_candidates.h"

namespace isthmus::matching {

// The newest submap aligned with the first few candidates that are known well enough, some 5 ms
// each; edges only where the alignment stays within what was known and free space agrees. Nothing
// where none does.
std::optional<LoopClosure> FollowLoop(const LoopScene& scene,
                                      const std::vector<LoopCandidate>& candidates,
                                      const LoopOptions& options, LoopSubmaps* submaps);

// The newest submap aligned likewise with the few before it, which are too near to be a loop.
// Nothing where no alignment contradicts odometry by more than alignments err: then it errs less.
std::optional<LoopClosure> FollowSteps(const LoopScene& scene, const LoopOptions& options,
                                       LoopSubmaps* submaps);

// True if that is so of a candidate.
bool IsKnownWell(const LoopCandidate& candidate);

}  // namespace isthmus::matching
