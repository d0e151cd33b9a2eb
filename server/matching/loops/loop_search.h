// A loop that is to be closed anew: the newest few submaps against the submaps around a place, as
// two maps are matched, within what odometry may have strayed.
#pragma once

#include <optional>

#include "core/map/loop_closure.h"
#include "server/matching/loops/loop_candidates.h"

namespace isthmus::matching {

// `candidate` is the middle of the place. Guesses are where odometry, the present placement and
// places that look alike have it; where these may all be too far off, a bird's-eye search as well,
// if `thorough`. Nothing where no guess stands, or two do. Some 0.1 s, with a search half a second
// indoors and a second outdoors.
std::optional<LoopClosure> CloseLoop(const LoopScene& scene, const LoopCandidate& candidate,
                                     const LoopOptions& options, bool thorough,
                                     LoopSubmaps* submaps);

}  // namespace isthmus::matching
