// The computing time of one scan's odometry.
#pragma once

namespace isthmus {

// Wall time, decoding apart.
struct ScanTiming {
  double features_ms = 0;  // Ring and time inference, smoothness, selection.
  double matching_ms = 0;  // Undistortion and scan-to-map matching, both stages.
  double map_ms = 0;       // Local map update.
  double total_ms = 0;
};

}  // namespace isthmus
