// Where to look for a robot that was not seen for a while.
#pragma once

#include <vector>

#include "floam/scan_matcher.h"

namespace isthmus::floam {

// Guesses of the pose `elapsed_s` after `last`: the prediction, the same motion slowed down, arcs
// of every curvature at up to the last speed, and a grid of places and headings nearby, at the last
// height and tilt. A few thousand at most. `reference_s` as in Predict.
std::vector<ScanPose> RecoveryGuesses(const ScanPose& last, double elapsed_s, double reference_s);

}  // namespace isthmus::floam
