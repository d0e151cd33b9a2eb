#include "server/matching/pairs/probability.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

// The weight of a measure. `typical`: its median over right hypotheses.
struct Coefficient {
  double weight = 0, typical = 0;
  double operator()(double measured) const { return weight * (measured - typical); }
};

// Fitted by lab/bench/merging/fit_probability.py to the hypotheses of 579 pairs of 104 worlds (wild
// ones of all kinds, cut to overlaps that were drawn, seeds 1100 to 1121, 1200 to 1219, 3300 to
// 3310, and whole, 4400 to 4410, 5500 to 5510, 5600 to 5610; museums of seeds 31 to 43, 60, 61, 81
// to 84, campuses of 60 and 61). lab/docs/merging.md says how well it holds in others.
constexpr Coefficient kLooserThanOwn{-9.58, 0.073}, kUpright{2.62, 0.114},
    kContradictedRegions{-2.94, 0.302}, kClean{6.63, 0.000}, kSharedArea{3.65, 3.022},
    kDistinctive{1.25, 2.666}, kRepeats{-3.60, 0.190};

// Fitted beside them to 218 pairs of 59 wild worlds, most of them furnished (seeds 9240 to 9268 and
// 9600 to 9629); places that are built alike and furnished differently had a tenth of the weight.
constexpr Coefficient kFurnished{3.33, -1.969};

double Tightness(const Hypothesis& h) {
  const double own = std::max(h.own.residual_m(), kLeastOwnResidualM);
  return kLooserThanOwn(10 * (h.residual_m - own));
}

double Agreement(const Hypothesis& h) {
  return kUpright(std::log(kNoUpright + std::min(UprightOfOwn(h), kMostUpright)));
}

// Counts, not shares: a large hall that agrees does not excuse a wing that does not. But where next
// to nothing of many comparisons is contradicted, nothing was moved either.
double FreeSpace(const FreeSpaceScore& score) {
  const auto regions = static_cast<double>(score.regions);
  const auto contradicted = static_cast<double>(score.contradicted_regions);
  const auto in_front = static_cast<double>(score.front);
  const double clean = std::log10((kFewComparisons + static_cast<double>(score.comparisons())) /
                                  (kFewContradictions + in_front)) -
                       kCleanFrom;
  return kContradictedRegions(std::log10(1 + contradicted / (1 + kRegionNoise * regions))) +
         kClean(std::clamp(clean, 0.0, kMostClean));
}

// Under a roof the first square metres say nothing by themselves: what stands there does.
double Ground(const Hypothesis& h) {
  return kSharedArea(
      std::log10(1 + (h.outdoors ? h.shared_area_m2 : std::max(h.shared_area_m2, kRoomsM2))));
}

// Things per square metre that are in both maps: buildings repeat their walls and corridors;
// nothing repeats where chairs, cars and boxes stand.
double Furnished(const Hypothesis& h) {
  if (h.outdoors) return 0;
  const auto there = static_cast<double>(h.things.there);
  const auto gone = static_cast<double>(h.things.gone);
  return kFurnished(
      std::log10((1 + there) / (1 + gone) / (kNoRoomM2 + std::min(h.shared_area_m2, kRoomsM2))));
}

// Inliers that would not agree elsewhere as well, and how much else would. A building turned over
// fits its mirror image: a hanging sensor is the less likely.
double Distinctive(const Hypothesis& h) {
  return (h.upside_down ? -kUpsideDownLogOdds : 0) +
         kDistinctive(std::log10(1 + static_cast<double>(h.distinctive))) + kRepeats(h.repetition);
}

double Odds(const Hypothesis& h) {
  return std::exp(std::clamp(MeasureLogOdds(h).sum(), -kMaxLogOdds, kMaxLogOdds));
}

}  // namespace

double LogOdds::sum() const { return std::accumulate(terms.begin(), terms.end(), kTypicalLogOdds); }

Term LogOdds::Weakest() const {
  return static_cast<Term>(std::min_element(terms.begin(), terms.end()) - terms.begin());
}

double UprightOfOwn(const Hypothesis& h) {
  const double own = h.own.near_upright > 0 ? std::max(h.own.upright_ratio(), kLeastOwnUpright) : 1;
  return h.upright_ratio / own;
}

LogOdds MeasureLogOdds(const Hypothesis& h) {
  return {{Tightness(h), Agreement(h), FreeSpace(h.free_space), Ground(h), Distinctive(h),
           Furnished(h), h.by_anchors}};
}

double ProbabilityAlone(const Hypothesis& h) {
  const double odds = Odds(h);
  return odds / (1 + odds);
}

std::vector<double> Probabilities(const std::vector<Hypothesis>& hypotheses) {
  std::vector<double> probabilities;
  double sum = 1;  // The odds that none is right.
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
