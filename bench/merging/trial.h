// Whether the server finds how two robots' maps lie to each other.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "bench/merging/pair.h"
#include "core/match.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

// How the maps lie on each other where both robots have been, by the pairs of poses that are
// nearest in truth: half a drive's drift, which no transform can take back, is not in it.
struct MapError {
  double median_m = 0, median_deg = 0;
  bool known = false;  // The robots have been near each other.
};

enum class TrialOutcome {
  kRight,      // Merged, and the maps lie within 0.3 m and 1 degree.
  kNotMerged,  // Not yet, ambiguous or rejected: Match::state and reason say which.
  kWrong,      // Merged otherwise.
};

struct Trial {
  uint64_t seed = 0;
  double overlap = 0;  // Share of the surface of the robot that saw less which the other saw too.
  Match match;
  TrialOutcome outcome = TrialOutcome::kNotMerged;
  MapError map;
  double start_m = 0, start_deg = 0;  // Of the transform between the start frames; if merged.
  double odometry_m = 0;              // RMSE of the worse robot in its own frame.
  int lost_scans = 0;
};

// Streams both drives through a pipeline with a store in memory, waits until it is done, and judges
// the match by the truth.
absl::StatusOr<Trial> RunTrial(const Pair& pair, uint64_t seed,
                               const server::PipelineOptions& options);

}  // namespace isthmus::bench
