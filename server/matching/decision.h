// What is to be made of the hypotheses about a pair of maps.
#pragma once

#include <string>
#include <vector>

#include "core/match.h"
#include "server/matching/free_space.h"
#include "server/matching/matcher.h"
#include "server/matching/refine.h"

namespace isthmus::matching {

// A refined guess with all that was measured of it.
struct Hypothesis {
  std::string source;
  Refinement refinement;
  FreeSpaceScore free_space;
  double shared_area_m2 = 0;  // Ground that both robots looked across.
  // Mean squared component of the inliers' normals along the direction in which the alignment is
  // held least; 0: it slides.
  double weakest_hold = 0;
  double max_free_space = 0;  // The limit that holds for this pair.

  // Agreement less contradiction, such that at the limit nothing is left: what hypotheses are
  // ranked by. Large where much was compared and little contradicted.
  double Support() const;
};

// Puts the best first.
void RankHypotheses(std::vector<Hypothesis>* hypotheses);

// Fills everything of `match` that follows from the hypotheses, best first: state, reason, detail,
// transform and all figures.
void Decide(const std::vector<Hypothesis>& ranked, const MatcherOptions& options, Match* match);

}  // namespace isthmus::matching
