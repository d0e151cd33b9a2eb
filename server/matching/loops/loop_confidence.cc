#include "server/matching/loops/loop_confidence.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

namespace isthmus::matching {

std::string CameBack(const LoopClosure& closure) {
  return absl::StrFormat("Submap %d came back to submap %d", closure.submap_b, closure.submap_a);
}

void DescribeLoop(double max_free_space, const std::string& event, LoopClosure* closure) {
  const double contradicted = closure->free_space / std::max(max_free_space, 1e-6);
  const double comparisons = static_cast<double>(closure->comparisons);
  const double logit = 0.5 + 1.5 * std::log10(1 + comparisons / 1000) -
                       2.0 * std::min(contradicted, 2.0) + 3.0 * closure->overlap;
  closure->confidence = 1 / (1 + std::exp(-logit));
  closure->detail = absl::StrFormat(
      "%s: overlap %.0f %%, %.2f %% of %d free-space comparisons contradicted, %d edges.", event,
      100 * closure->overlap, 100 * closure->free_space, closure->comparisons,
      closure->edges.size());
}

}  // namespace isthmus::matching
