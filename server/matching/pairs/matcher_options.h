// Limits of acceptance. A wrong merge destroys a map, a missed one costs a minute: when in doubt,
// raise them.
//
// Chosen with merging_benchmark's seeds 11 to 20 in view, and held on 21 to 30: none wrong
// (BENCHMARK.md, Merging). max_free_space was five times as much before hypotheses were refined
// jointly, outdoors twice (decision 0010). Wrong on the lenient side, twins are merged.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

namespace isthmus::matching {

// Who proposes transforms.
enum class SearchMode {
  // The bird's-eye search, and the paper's feature chain where that leaves the pair undecided
  // indoors (outdoors it costs seconds and finds nothing at realistic overlap).
  kDefault,
  kPaper,     // The feature chain only, where it was built (core/paper.h).
  kBirdsEye,  // The search only.
};

struct MatcherOptions {
  SearchMode search = SearchMode::kDefault;
  double min_overlap = 0.1;        // Less: NOT_YET.
  int64_t min_comparisons = 3000;  // Fewer free-space comparisons: NOT_YET.
  double max_free_space = 0.005;   // More contradicted: REJECTED. Where there are ceilings ...
  double max_free_space_outdoors = 0.04;  // ... and under the open sky.
  double min_margin = 3;  // Runner-up's free_space over the best's; less: AMBIGUOUS.
  // A rival's residual over the best's; less, at a place that is not far worse otherwise:
  // AMBIGUOUS.
  double max_tighter_residual = 0.9;
  double min_shared_area_m2 = 200;  // Less ground seen by both: NOT_YET, one room has twins.
  // If neither map shows much beyond the ground that both know, a twin of the place explains both
  // equally well: the pair is AMBIGUOUS. The shared ground may be this share of what the robot
  // knows that knows more, as far as it is up to 400 m2, and more the larger it is; from so much on
  // all of it.
  double max_enclosed_share = 0.6;
  double min_enclosed_area_m2 = 1000;
  double min_observability = 0.02;  // Mean squared normal along the direction held least.
  double max_odometry_residual =
      3;  // Standard deviations that the odometry may bend; more: NOT_YET.
  // Ends a match early; what comes of it then is to be thrown away.
  std::stop_token stop = {};
};

}  // namespace isthmus::matching
