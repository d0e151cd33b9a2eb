// Limits of the check of cycles that its options do not have.
#pragma once

#include <cstddef>

namespace isthmus::match_graph {

// Confidence that no match exceeds when odds are compared: certainty is never complete, and odds
// stay finite. Any value near 1 does.
inline constexpr double kMaxConfidence = 1 - 1e-6;
// Matches of the longest cycles that count whenever they disagree: squares. On longer ones whose
// matches others bear out it is drift that adds up. A guess, never varied.
inline constexpr size_t kShortCycle = 4;

}  // namespace isthmus::match_graph
