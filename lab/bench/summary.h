// A run in figures.
#pragma once

#include <optional>
#include <vector>

#include "lab/bench/drive.h"
#include "lab/bench/run.h"

namespace isthmus::bench {

struct CostSummary {
  double median_ms = 0, p99_ms = 0, max_ms = 0;         // Whole scans.
  double features_ms = 0, matching_ms = 0, map_ms = 0;  // Medians.
  std::optional<double> early_ms, late_ms;  // Medians of scans 200 to 300 and of the last 100.
  std::optional<double> lost_ratio;  // A lost scan to another, means; of drives with some of both.
};

// Positions, in metres, and angles, in degrees, of scans that were not lost or rejected. A later
// segment, in a frame of its own, counts from where all of it fits the truth best.
struct ErrorSummary {
  // After rigid alignment (Umeyama, as evaluation::Alignment); of the last scan.
  double rmse_m = 0, worst_m = 0, last_m = 0;
  // With the first poses made to coincide, so that orientations count from the start. Heading is
  // the error's turn about the vertical, tilt that about horizontal axes.
  double first_rmse_m = 0, first_worst_m = 0, final_m = 0;
  double heading_rmse_deg = 0, heading_worst_deg = 0;
  double tilt_rmse_deg = 0, tilt_worst_deg = 0;
};

struct CountSummary {
  int ok = 0, degenerate = 0, lost = 0, rejected = 0;
  int segments = 0;
  // Claimed ok but wrong (see Drive::wrong_m), in either alignment.
  int silent = 0;
  int covered_ok = 0;  // Claimed ok with the view covered in part or whole.
};

// In the bare part of the world "corridor", which lies along x. Aligned at the first poses.
struct CorridorSummary {
  double along_worst_m = 0, across_worst_m = 0, height_worst_m = 0, heading_worst_deg = 0;
  double flagged = 0;  // Share of scans that say they do not observe their way along it.
};

struct LapSummary {
  double median_ms = 0;
  double odometry_mb = 0;  // Kept at its end.
  double rmse_m = 0;       // First poses made to coincide.
};

struct Summary {
  CostSummary cost;
  ErrorSummary error;
  CountSummary counts;
  double cal_ms = 0, odometry_mb = 0, peak_mb = 0;
  // From the end of the trouble to the first pose that is not lost and not wrong: scans; -1 if
  // there is none. Absent if there was no trouble.
  std::optional<int> scans_to_recover;
  std::optional<CorridorSummary> corridor;
  std::vector<LapSummary> laps;
};

// The value that a share of `share` is not above, by the nearest rank; 0 of nothing.
double Percentile(std::vector<double> values, double share);

// `is_corridor`: the drive is in the world "corridor".
Summary Summarize(const Drive& drive, const RunRecord& run, bool is_corridor);

}  // namespace isthmus::bench
