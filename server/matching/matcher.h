// From two sessions' maps to a verified match: search, refine, verify, decide.
#pragma once

#include <string>

#include "core/match.h"
#include "core/submap.h"

namespace isthmus::matching {

struct MatcherOptions {
  // "default": the paper's feature chain and the bird's-eye search both propose. "paper": the
  // feature chain only. "birds_eye": the search only.
  std::string search = "default";
  double min_overlap = 0.1;            // Less: NOT_YET.
  int64_t min_comparisons = 300;       // Fewer free-space comparisons: NOT_YET.
  double max_free_space = 0.1;         // More contradicted: REJECTED.
  double min_margin = 1.5;             // Runner-up's free_space over the best's; less: AMBIGUOUS.
};

// The match of the pair (a, b), a.session < b.session; every field of Match is filled but
// computed_ns. Never fails: what cannot be decided is NOT_YET with a reason. Deterministic. Thread
// safe. Starts no threads beyond what PCL's OpenMP does when called from one thread.
Match MatchSessions(const SessionMap& a, const SessionMap& b, const MatcherOptions& options);

}  // namespace isthmus::matching
