// Scores of the odometry on a wild drive.
#pragma once

#include <string>
#include <vector>

#include "lab/bench/run.h"

namespace isthmus::bench {

// Poses of different segments share no frame: each is judged by itself.
struct WildScore {
  int scans = 0, ok = 0, degenerate = 0, lost = 0, rejected = 0, segments = 0;
  // The lost ones whose pose is right all the same: since the last pose of their segment
  // that was not lost they moved as the truth did, within 5 cm and 1 degree.
  int lost_though_right = 0;
  // Stretches of lost and rejected scans, a pose known again only after them.
  double longest_lost_s = 0;
  double lost_long = 0;      // Share of scans in stretches longer than kLongLostS.
  double path_length_m = 0;  // By the truth.
  // Positions of scans that claim to be ok after rigid alignment, segment by segment.
  double rmse_m = 0, worst_m = 0;
  double rmse_percent = 0;   // Relative to the way.
  double posed_percent = 0;  // The same of all scans with a pose, degenerate ones too.
  // Scans that claim to be ok, yet their motion over the last 10 m of way, or less at the
  // beginning of a segment, is more than 0.3 m and 1 % of that way off the truth, seen from its end
  // and from its beginning; of these those
  // without a degenerate scan in that stretch, which would have told.
  int silent = 0, silent_untold = 0;
  double median_ms = 0;
};

constexpr double kLongLostS = 2;

WildScore ScoreWildDrive(const std::vector<ScanRecord>& scans, double period_s);

}  // namespace isthmus::bench
