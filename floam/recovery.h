// Finding a lost robot again in the map around where it was last.
#pragma once

#include "floam/feature_map.h"
#include "floam/scan_frame.h"
#include "floam/tracker.h"

namespace isthmus::floam {

// Looks at a few thousand guesses at a glance, matches properly from the best, and from the very
// best with all features. The caller judges the result.
MatchResult Recover(const ScanFrame& frame, const MatchOptions& options, Tracker* tracker,
                    FeatureMap* map);

}  // namespace isthmus::floam
