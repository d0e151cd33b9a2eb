// The first two scans: a motion and a map out of nothing.
#pragma once

#include <cstdint>

#include "floam/feature_map.h"
#include "floam/scan_frame.h"
#include "floam/tracker.h"

namespace isthmus::floam {

// The motion within the first scan is only known once the second is matched to it, which depends on
// that motion: taken to be constant over both, it is found by repetition. Not thread safe.
class Start {
 public:
  // Puts the first scan at the origin, as if at rest.
  void First(const ScanFrame& frame, Tracker* tracker);
  // Matches the second, and makes the map of the first as the motion found says.
  MatchResult Second(const ScanFrame& frame, Tracker* tracker, FeatureMap* map);

 private:
  Features first_;
  double period_s_ = 0;
  int64_t stamp_ns_ = 0;
};

}  // namespace isthmus::floam
