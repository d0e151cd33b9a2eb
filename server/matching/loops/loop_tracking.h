// A loop that goes on: where the newest submap lies on older ones is known to within what an
// alignment of two submaps captures.
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

// True if that is so of a candidate.
bool IsKnownWell(const LoopCandidate& candidate);

}  // namespace isthmus::matching
