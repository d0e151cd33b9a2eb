// The probability that a hypothesis about a pair of maps is right: how well surfaces lie on each
// other for this world and these sensors, what is contradicted, how much is shared, how much of it
// the world does not repeat; what anchors say; and what else the maps allow.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "server/matching/pairs/hypothesis.h"

namespace isthmus::matching {

// The terms that add up to the log odds of a hypothesis.
enum class Term { kTightness, kAgreement, kFreeSpace, kGround, kDistinctive, kThings, kAnchors };

// The log odds of being right against there being no right one among a pair's hypotheses.
struct LogOdds {
  std::array<double, 7> terms{};  // By Term; 0: as good as a right one usually is.
  double sum() const;
  // The term by which it falls behind right ones most.
  Term Weakest() const;
};

// Share of what stands upright that lies on the other map, against each session's own.
double UprightOfOwn(const Hypothesis& h);

LogOdds MeasureLogOdds(const Hypothesis& h);

// The probability that one is right which nothing else competes with.
double ProbabilityAlone(const Hypothesis& h);

// The probability of each that it is right. At most one is, and perhaps none: exp(u_i) / (1 + sum
// of exp(u_j)), u being the log odds (conditional logit, McFadden, "Conditional logit analysis of
// qualitative choice behavior", 1974, equation 12).
std::vector<double> Probabilities(const std::vector<Hypothesis>& hypotheses);

// Puts the most probable first.
void RankByProbability(std::vector<Hypothesis>* hypotheses);

}  // namespace isthmus::matching
