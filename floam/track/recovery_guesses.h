// Guesses at where a robot is that was not tracked for a while.
#pragma once

#include <vector>

#include "floam/match/scan_matcher.h"

namespace isthmus::floam {

// Guesses of the pose `elapsed_s` after `last`, all with its twist; `reference_s` as in Predict.

// The prediction, and the same motion slowed down: five.
std::vector<ScanPose> LikelyGuesses(const ScanPose& last, double elapsed_s, double reference_s);

// Arcs of every curvature at up to the last speed, the farthest first, and a grid of places and
// headings nearby, at the last height and tilt. A few thousand.
std::vector<ScanPose> NearbyGuesses(const ScanPose& last, double elapsed_s, double reference_s);

}  // namespace isthmus::floam
