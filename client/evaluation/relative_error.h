// Errors of an estimated motion from one pose to a later one, which no alignment changes.
#pragma once

#include <cstddef>
#include <vector>

#include "client/evaluation/association.h"
#include "client/evaluation/statistics.h"

namespace isthmus::evaluation {

enum class DeltaUnit { kFrames, kMetres, kSeconds };

// From which pose to which later one.
struct Delta {
  double value = 1;
  DeltaUnit unit = DeltaUnit::kFrames;
};

// count is 0 where the drive is shorter than the delta.
struct RelativeErrors {
  Statistics m;    // Lengths of the errors' translations, metres.
  Statistics deg;  // Angles of their rotations, degrees.
};

// From every pose i to the first j after it that is `delta` away: so many poses, metres of the way
// along the truth, or seconds. The error is that of eq. 1 of Sturm et al., "A benchmark for the
// evaluation of RGB-D SLAM systems", IROS 2012: (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), with Q the truth and
// P the estimate. Pairs are in order of time.
RelativeErrors CompareSteps(const std::vector<PosePair>& pairs, const Delta& delta);

// The segments of one length.
struct SegmentErrors {
  double length_m = 0;
  std::vector<double> percent;       // Translation, of the length.
  std::vector<double> deg_per_100m;  // Rotation.
};

struct DriftErrors {
  std::vector<SegmentErrors> lengths;  // Lengths with segments in the drive, the shortest first.
  bool is_kitti = true;                // The lengths are KITTI's, else shorter ones.
  size_t stride = 1;                   // Every how many poses a segment begins.
  // Means over all segments of all lengths, as KITTI's table ranks by; 0 where there are none.
  double percent = 0, deg_per_100m = 0;
};

// The lengths to judge a drive of that many metres by: KITTI's that it has; for one that is shorter
// than kShortDriveM eight multiples of 1, 2 or 5 times a power of ten. None for a way of 0.
std::vector<double> SegmentLengths(double way_m);

// KITTI's errors of odometry: for each length L the segments from a pose to the first one that is
// more than L farther along the truth, |translation of the error| / L and its angle / L.
DriftErrors CompareSegments(const std::vector<PosePair>& pairs);

}  // namespace isthmus::evaluation
