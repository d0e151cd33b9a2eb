// Does one map put a wall where the other robot looked through? The test that tells right merges
// from wrong ones: inliers, overlap and residuals do not (two identical rooms agree perfectly).
#pragma once

#include <cstdint>

#include "core/submap.h"

namespace isthmus::matching {

struct FreeSpaceOptions {
  double margin_m = 0.4;            // A point contradicts when it lies this much ...
  double margin_per_m = 0.01;       // ... plus this share of the range in front of what was measured.
  double max_range_m = 25;
  double max_abs_normal_z = 0.5;    // Only near-vertical surfaces are asked.
};

struct FreeSpaceScore {
  int64_t agree = 0;    // The point lies at the measured range.
  int64_t front = 0;    // The point lies in front of it: contradicted.
  int64_t comparisons() const { return agree + front; }
  // Share of contradicted comparisons in [0, 1]; 0 without comparisons, which is not evidence.
  double violation() const { return comparisons() ? double(front) / comparisons() : 0; }
};

// Both ways: a's points against b's keyframes' range images and b's against a's. Thread safe.
FreeSpaceScore ScoreFreeSpace(const SessionMap& a, const SessionMap& b, const Pose& T_a_b,
                              const FreeSpaceOptions& options);

}  // namespace isthmus::matching
