// Guesses at where a sensor stood when it saw a map that came without sensor poses.
#pragma once

#include "core/cloud.h"
#include "core/map/trajectory.h"

namespace isthmus::cli {

// Places 1 m above open floor, some metres apart, at most 64 of them; z must point about up. The
// stamps count from 0. Empty where there is no floor. A guess: good enough to search for
// alignments, which wants to know walls from what is behind them, and no evidence of anything that
// was seen.
Trajectory GuessViewpoints(const Cloud& points);

}  // namespace isthmus::cli
