// From two sessions' maps to a verified match: search, refine, verify, decide.
#pragma once

#include <string>

#include "core/match.h"
#include "core/submap.h"

namespace isthmus::matching {

class PreparedMap;  // server/matching/prepared_map.h

// Limits of acceptance. A wrong merge destroys a map, a missed one costs a minute: when in doubt,
// raise them.
struct MatcherOptions {
  // "default": the bird's-eye search proposes, and the paper's feature chain where that leaves the
  // pair undecided indoors (outdoors it costs seconds and finds nothing at realistic overlap).
  // "paper": the feature chain only. "birds_eye": the search only.
  std::string search = "default";
  double min_overlap = 0.1;        // Less: NOT_YET.
  int64_t min_comparisons = 3000;  // Fewer free-space comparisons: NOT_YET.
  double max_free_space = 0.02;    // More contradicted: REJECTED. Where there are ceilings ...
  double max_free_space_outdoors = 0.08;  // ... and under the open sky.
  double min_margin = 3;            // Runner-up's free_space over the best's; less: AMBIGUOUS.
  double min_shared_area_m2 = 200;  // Less ground seen by both: NOT_YET, one room has twins.
  double min_hold = 0.02;           // Mean squared normal along the direction held least.
};

// The match of the pair (a, b), a.session < b.session; every field of Match is filled but
// computed_ns. Never fails: what cannot be decided is NOT_YET with a reason. Deterministic. Thread
// safe. Starts no threads beyond what PCL's OpenMP does when called from one thread.
//
// Reasons: OK (ACCEPTED); FREE_SPACE (REJECTED); AMBIGUOUS (AMBIGUOUS); LOW_OVERLAP,
// FEW_COMPARISONS, TOO_SMALL, NO_CANDIDATE, DEGENERATE, NOT_CONVERGED (NOT_YET).
Match MatchSessions(const SessionMap& a, const SessionMap& b, const MatcherOptions& options);

// The same from maps made ready before, for those who match one map against many. The stage
// "prepare" is then what making them took, though not in this call.
Match MatchPrepared(const PreparedMap& a, const PreparedMap& b, const MatcherOptions& options);

}  // namespace isthmus::matching
