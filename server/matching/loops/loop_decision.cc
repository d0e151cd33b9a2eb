#include "server/matching/loops/loop_decision.h"

#include <algorithm>

#include "server/matching/loops/limits.h"
#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

bool KeepsLimits(const Hypothesis& h, const LoopOptions& options) {
  return h.converged && h.free_space.comparisons() >= options.min_comparisons &&
         h.overlap >= options.min_overlap && h.free_space.violation() <= h.max_free_space &&
         h.observability >= options.min_observability &&
         h.odometry_residual <= options.max_odometry_residual;
}

bool IsRival(const Hypothesis& h, const Hypothesis& best, const LoopOptions& options) {
  const double floor = std::max(best.free_space.violation(), kFreeSpaceNoise);
  return h.free_space.comparisons() >= options.min_comparisons &&
         h.overlap >= 0.5 * options.min_overlap && h.Support() >= kMinRivalShare * best.Support() &&
         h.free_space.violation() < options.min_margin * floor;
}

}  // namespace

const Hypothesis* ChooseLoop(const std::vector<Hypothesis>& ranked, const LoopOptions& options) {
  if (ranked.empty() || !KeepsLimits(ranked.front(), options)) return nullptr;
  const bool ambiguous = std::any_of(ranked.begin() + 1, ranked.end(), [&](const Hypothesis& h) {
    return IsRival(h, ranked.front(), options);
  });
  return ambiguous ? nullptr : &ranked.front();
}

}  // namespace isthmus::matching
