// Limits for recognising a place that a robot has seen before.
//
// Drift is by far that of a worse odometry than ours (lab/docs/mapping.md); the limits of
// free space were never varied by themselves and held on mapping_benchmark's loops, of which none
// is false.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/matching/prepared/limits.h"
#include "server/pose_graph/information.h"

namespace isthmus::matching {

struct LoopOptions {
  bool enabled = true;
  // Places a shorter way back are left to the odometry.
  double min_path_length_m = 40;
  // The worst drift of odometry. A robot that odometry puts elsewhere, by more of these standard
  // deviations, is not there however alike the places look.
  pose_graph::DriftModel drift = kPoorOdometry;
  double drift_sigmas = 4;
  // Limits of the newest submaps on those of a place: overlap and free space as in Match, the least
  // and the most; margin of the next best place's free space over the best's. The ground that they
  // share does not count: where the robot is, odometry says.
  double min_overlap = 0.3;
  int64_t min_comparisons = 1000;
  double max_free_space = 0.02;
  double max_free_space_outdoors = 0.08;
  double min_margin = 2;
  double min_observability = 0.02;
  double max_odometry_residual = 4;
  // The greatest number of edges of a new submap.
  size_t max_edges = 4;
  // Prepared submaps that are kept in memory, about a megabyte each; at least 16.
  size_t prepared_submaps = 64;

  friend bool operator==(const LoopOptions&, const LoopOptions&) = default;
};

}  // namespace isthmus::matching
