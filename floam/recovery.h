// Where to look for a robot that was not seen for a while.
#pragma once

#include <vector>

#include "floam/scan_matcher.h"

namespace isthmus::floam {

// Pose extrapolated by the twist, at most a few seconds: what is said while nothing is seen.
// `reference_s` is that of the result, relative to the END of the new scan.
ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s);

// Guesses of the pose `elapsed_s` after `last`: the prediction, the same motion slowed down, arcs
// of every curvature at up to the last speed, and a grid of places and headings nearby, at the last
// height and tilt. A few thousand at most.
std::vector<ScanPose> RecoveryGuesses(const ScanPose& last, double elapsed_s, double reference_s);

// How well scans matched lately, to tell a place found again from one that only looks like it.
class MatchQuality {
 public:
  // Of a scan that was tracked without interruption.
  void Add(const MatchResult& match);
  // Whether a match after an interruption is about as good.
  bool IsTypical(const MatchResult& match) const;

 private:
  double agreement_ = 0, share_ = 0;  // Fading averages; zero before the first Add.
};

}  // namespace isthmus::floam
