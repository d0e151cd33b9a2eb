#include "server/matching/asking/forecast.h"

#include <algorithm>
#include <cmath>

#include "server/matching/asking/limits.h"
#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

// New comparisons are contradicted as few as at right places.
FreeSpaceScore Grown(const FreeSpaceScore& score, double growth) {
  const double comparisons = growth * static_cast<double>(score.comparisons());
  const double regions = growth * static_cast<double>(score.regions);
  FreeSpaceScore grown = score;
  grown.agree += std::llround(comparisons * (1 - kRegionNoise));
  grown.front += std::llround(comparisons * kRegionNoise);
  grown.regions += std::llround(regions);
  grown.contradicted_regions += std::llround(regions * kRegionNoise);
  return grown;
}

}  // namespace

Hypothesis Foresee(const Hypothesis& h, const Evidence& ahead, double known_m2) {
  const double growth = kSeenAgain * ahead.ground_m2 / std::max(known_m2, kLeastKnownM2);
  const double is_new = growth / (1 + growth);
  Hypothesis foreseen = h;
  foreseen.shared_area_m2 *= 1 + growth;
  foreseen.shared_share = std::min(1.0, h.shared_share * (1 + growth));
  foreseen.free_space = Grown(h.free_space, growth);
  foreseen.distinctive += std::llround(kSeenAgain * ahead.distinctive);
  foreseen.things.there += std::llround(kSeenAgain * ahead.things);
  if (h.own.on > 0) {
    const double own = std::max(h.own.residual_m(), kLeastOwnResidualM);
    foreseen.residual_m =
        std::sqrt((1 - is_new) * h.residual_m * h.residual_m + is_new * own * own);
  }
  if (h.own.near_upright > 0) {
    foreseen.upright_ratio = (1 - is_new) * h.upright_ratio + is_new * h.own.upright_ratio();
  }
  return foreseen;
}

}  // namespace isthmus::matching
