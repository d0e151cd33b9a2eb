#include "server/matching/pairs/probability.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

// What is measured, times its weight. `typical`: of right hypotheses, median.
struct Weight {
  double weight = 0, typical = 0;
  double operator()(double measured) const { return weight * (measured - typical); }
};

// Fitted by bench/merging/fit_probability.py to the hypotheses of 400 pairs of wild worlds (all
// kinds, of seeds 1100 to 1121, 1200 to 1219, 3300 to 3310; 1225, 1228, 1229, 1231, 1232) and of
// museums and campuses (seeds 60 and 61). docs/benchmarks/merging.md has the curve on others.
constexpr Weight kLooserThanOwn{-2.43, 0.270}, kLoose{-6.28, 0.536}, kUpright{4.42, 0.987},
    kInFront{-1.51, 1.828}, kContradictedRegions{-1.41, 0.262}, kAgreeing{0.89, 0.272},
    kSharedArea{3.37, 2.885}, kHeld{0.50, -0.889}, kRepeats{-7.01, 0.056},
    kRepeatsWhereShared{-4.07, 0.064};

double Tightness(const Hypothesis& h) {
  const double own = std::max(h.own.residual_m(), kLeastOwnResidualM);
  return kLooserThanOwn(std::log((h.residual_m + kResidualNoiseM) / own)) +
         kLoose(10 * h.residual_m);
}

double Agreement(const Hypothesis& h) {
  const double own = std::max(h.own.upright_ratio(), kLeastOwnUpright);
  return kUpright(std::min(h.upright_ratio / own, kMostUpright));
}

// Counts, not shares: a large hall that agrees does not excuse a wing that does not.
double FreeSpace(const FreeSpaceScore& score) {
  const auto agree = static_cast<double>(score.agree), front = static_cast<double>(score.front);
  const auto regions = static_cast<double>(score.regions);
  const auto contradicted = static_cast<double>(score.contradicted_regions);
  const double agreeing =
      std::log10((agree + kFewAgreeing) / (kContradictionsOutweigh * front + kFewAgreeing));
  return kInFront(std::log10(1 + front)) +
         kContradictedRegions(std::log10(1 + contradicted / (1 + kRegionNoise * regions))) +
         kAgreeing(std::max(0.0, agreeing));
}

double Ground(const Hypothesis& h) { return kSharedArea(std::log10(1 + h.shared_area_m2)); }

double Hold(const Hypothesis& h) {
  return kHeld(std::log10(std::max(h.observability, kLeastObservability)));
}

// A building turned over fits its mirror image: that a sensor hangs is the less likely.
double Repetition(const Hypothesis& h) {
  return (h.upside_down ? -kUpsideDownLogOdds : 0) + kRepeats(h.repetition * h.repetition) +
         kRepeatsWhereShared(h.repetition * h.shared_share);
}

double Odds(const Hypothesis& h) {
  return std::exp(std::clamp(MeasureLogOdds(h).sum(), -kMaxLogOdds, kMaxLogOdds));
}

}  // namespace

double LogOdds::sum() const { return std::accumulate(terms.begin(), terms.end(), kTypicalLogOdds); }

Term LogOdds::Weakest() const {
  return static_cast<Term>(std::min_element(terms.begin(), terms.end()) - terms.begin());
}

LogOdds MeasureLogOdds(const Hypothesis& h) {
  return {{Tightness(h), Agreement(h), FreeSpace(h.free_space), Ground(h), Hold(h), Repetition(h)}};
}

double ProbabilityAlone(const Hypothesis& h) {
  const double odds = Odds(h);
  return odds / (1 + odds);
}

std::vector<double> Probabilities(const std::vector<Hypothesis>& hypotheses) {
  std::vector<double> probabilities;
  double sum = 1;  // Of none's being right.
  for (const Hypothesis& h : hypotheses) {
    probabilities.push_back(Odds(h));
    sum += probabilities.back();
  }
  for (double& probability : probabilities) probability /= sum;
  return probabilities;
}

void RankByProbability(std::vector<Hypothesis>* hypotheses) {
  std::stable_sort(hypotheses->begin(), hypotheses->end(),
                   [](const Hypothesis& x, const Hypothesis& y) {
                     return MeasureLogOdds(x).sum() > MeasureLogOdds(y).sum();
                   });
}

}  // namespace isthmus::matching
