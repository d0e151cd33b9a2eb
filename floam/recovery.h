// Where to look for a robot that was not seen for a while.
#pragma once

#include <vector>

#include "floam/scan_matcher.h"

namespace isthmus::floam {

// Guesses of the pose `elapsed_s` after `last`, the likeliest first: the motion went on, slowed
// down or stopped, with the heading off by up to what a robot may turn meanwhile. `reference_s` is
// that of the guesses, relative to the END of the new scan.
std::vector<ScanPose> RecoveryGuesses(const ScanPose& last, double elapsed_s, double reference_s);

// Pose extrapolated by the twist, at most a few seconds: what is said while nothing is seen.
ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s);

}  // namespace isthmus::floam
